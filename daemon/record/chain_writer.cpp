#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/chain_tables.hpp"
#include "daemon/record/chain_tail.hpp"
#include "daemon/record/regular_file.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/sqlite.hpp"

namespace dwell::record {
namespace {

// Bytes of a page. A block has 10 kB to some MB, so larger pages mean fewer links to follow. But each commit, one a
// second, rewrites about three pages.
constexpr const char* kPageSize = "PRAGMA page_size = 16384";

// Frames of the log after which its pages go into the database: 16 MB, some seconds of the largest rig.
constexpr int kCheckpointFrames = 1000;
constexpr int kMostFrames = static_cast<int>(ChainReader::kMaxWal / 16384);

// Whether SQLite waits for the disk. Without waits, whoever calls it does.
constexpr const char* kWaits = "PRAGMA synchronous = FULL";
constexpr const char* kNoWaits = "PRAGMA synchronous = OFF";

// Largest body of an entry that readers take.
std::size_t most_bytes(std::string_view kind) {
  return kind == "stream" ? static_cast<std::size_t>(ChainReader::kMaxBody) : kMaxJson;
}

// While the connection is open, no other one can open the file, and SQLite needs no -shm. To reopen a closed file,
// SQLite changes its mode in a transaction. The rollback journal of that stays in memory: an audit at that moment would
// report a -journal on the disk as tampering.
bool set_up(sqlite3* database) {
  return execute(database, "PRAGMA locking_mode = EXCLUSIVE") &&
         (first_text(database, "PRAGMA journal_mode") == "wal" ||
          first_text(database, "PRAGMA journal_mode = MEMORY") == "memory") &&
         first_text(database, "PRAGMA journal_mode = WAL") == "wal" && execute(database, kWaits) &&
         execute(database, "PRAGMA wal_autocheckpoint = 0");
}

Database open_database(const std::string& path, int flags) {
  sqlite3* opened = nullptr;
  sqlite3_open_v2(path.c_str(), &opened, flags | SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  if (opened != nullptr) sqlite3_extended_result_codes(opened, 0);
  return Database(opened);
}

// Waits until what `path`, a file or a directory, holds now survives a loss of power. errno says why not. Not for a
// file that SQLite has open: closing any descriptor of it takes away all locks that this process has on it (fcntl(2)),
// and another process could write as well.
bool synchronize(const std::string& path, int flags = 0) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | flags);
  if (file < 0) return false;
  const bool done = ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  errno = error;
  return done;
}

// The same for what the directory of `path` says of its files.
bool synchronize_directory(const std::string& path) {
  const std::string directory = std::filesystem::path(path).parent_path().string();
  return synchronize(directory.empty() ? "." : directory, O_DIRECTORY);
}

// Makes an empty chain under another name, waits for the disk once, then renames the file to `path`. The rename
// survives a loss of power from the first commit on: SQLite then synchronizes the directory for the -wal.
Result<void> make_file(const std::string& path, ChainSort sort) {
  const std::string unfinished = path + ".new";
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, ignored))) return fails(path + ": exists already");
  // Removes what a crash left of an earlier try. SQLite would take an old log for that of the new file.
  for (const std::string& old :
       {unfinished, unfinished + "-journal", unfinished + "-wal", path + "-wal", path + "-shm", path + "-journal"})
    std::filesystem::remove(old, ignored);
  const std::string set =
      std::string(kPageSize) +
      "; PRAGMA locking_mode = EXCLUSIVE; PRAGMA synchronous = OFF; PRAGMA journal_mode = MEMORY; BEGIN; "
      "PRAGMA application_id = " +
      std::to_string(static_cast<std::uint32_t>(sort)) + "; PRAGMA user_version = " + std::to_string(kFormatVersion) +
      "; " + kEntryTable + "; " + kNoteTable + "; COMMIT";
  Database database = open_database(unfinished, SQLITE_OPEN_CREATE);
  if (!execute(database.get(), set.c_str()) || first_text(database.get(), "PRAGMA journal_mode = WAL") != "wal") {
    std::string error = sqlite_error(database.get(), path);
    database.reset();
    std::filesystem::remove(unfinished, ignored);
    return fails(std::move(error));
  }
  database.reset();
  if (!synchronize(unfinished) || std::rename(unfinished.c_str(), path.c_str()) != 0) {
    const int error = errno;
    std::filesystem::remove(unfinished, ignored);
    return fails(path + ": " + std::strerror(error));
  }
  return {};
}

// Whoever writes needs a log beside the file.
Result<void> may_have_log(const std::string& path) {
  const std::string log = path + "-wal";
  struct stat status {};
  if (::lstat(log.c_str(), &status) == 0)
    return S_ISREG(status.st_mode) ? Result<void>() : fails(log + ": is no regular file");
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) == 0) return {};
  return fails(path + ": a log beside it is needed, and no file can be made there: " + std::strerror(errno));
}

}  // namespace

struct ChainWriter::Impl {
  std::string path, origin;
  std::optional<SigningKey> key;  // none: commits carry no note
  Database database;
  Statement insert_entry, insert_note;
  ChainTail pending, committed;
  std::int64_t t_ns = 0;   // of the last entry appended
  int frames = 0;          // of the log, after the last commit
  OpenFile wal_file;       // for its flock: Snapshot
  bool stale_log = false;  // frames of a failed transaction may follow the log's end
  bool new_log = false;    // the log is empty, and SQLite does not wait for the disk: the next commit does
  std::string broken;      // why nothing more may be written; empty: it may
  // Which file it is.
  dev_t device = 0;
  ino_t inode = 0;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    insert_entry.reset();
    insert_note.reset();
    database.reset();
  }

  [[nodiscard]] tl::unexpected<Failure> failed() {
    std::string error = sqlite_error(database.get(), path);
    roll_back();
    return fails(std::move(error));
  }

  Result<void> connect(const WhileBusy& busy = {}) {
    database = open_database(path, 0);
    if (!database || !while_busy(database.get(), busy, set_up)) return fails(sqlite_error(database.get(), path));
    struct stat opened {};
    if (::stat(path.c_str(), &opened) != 0) return fails(path + ": " + std::strerror(errno));
    device = opened.st_dev;
    inode = opened.st_ino;
    insert_entry = prepare(database.get(), "INSERT INTO entry (seq, kind, t_ns, body, head) VALUES (?, ?, ?, ?, ?)");
    insert_note = prepare(database.get(), "INSERT INTO note (seq, text) VALUES (?, ?)");
    if (!insert_entry || !insert_note) return fails(sqlite_error(database.get(), path));
    sqlite3_wal_hook(
        database.get(),
        [](void* own, sqlite3*, const char*, int count) {
          static_cast<Impl*>(own)->frames = count;
          return SQLITE_OK;
        },
        this);
    return {};
  }

  // Fails if the file has been removed or replaced. SQLite would go on writing into a file that no name leads to.
  [[nodiscard]] Result<void> in_its_place() const {
    struct stat now {};
    if (::stat(path.c_str(), &now) != 0)
      return errno == ENOENT ? fails(path + ": the file was removed while it was written") : Result<void>();
    if (now.st_dev == device && now.st_ino == inode) return {};
    return fails(path + ": was replaced while it was written");
  }

  void roll_back() {
    // Cannot fail: a failure of SQLite's own has rolled back already.
    if (database && sqlite3_get_autocommit(database.get()) == 0) (void)execute(database.get(), "ROLLBACK");
    stale_log = stale_log || pending.seq != committed.seq;
    pending = committed;
  }

  static bool run(sqlite3_stmt* statement) {
    const int code = sqlite3_step(statement);
    sqlite3_reset(statement);
    sqlite3_clear_bindings(statement);
    return code == SQLITE_DONE;
  }

  bool add_note() {
    if (!key || pending.note.seq == pending.seq) return true;
    const std::string note = key->sign(note_text(origin, pending.seq, pending.head, t_ns, pending.note));
    pending.note = {pending.seq, note_hash(note)};
    sqlite3_bind_int64(insert_note.get(), 1, pending.seq);
    sqlite3_bind_text(insert_note.get(), 2, note.data(), static_cast<int>(note.size()), SQLITE_STATIC);
    return run(insert_note.get());
  }

  [[nodiscard]] bool move_log(int mode) {
    return sqlite3_wal_checkpoint_v2(database.get(), nullptr, mode, nullptr, nullptr) == SQLITE_OK;
  }

  // Waits until what the database's file holds now survives a loss of power: through SQLite's own descriptor, see
  // above.
  [[nodiscard]] Result<void> synchronize_database() {
    sqlite3_file* file = nullptr;
    if (sqlite3_file_control(database.get(), "main", SQLITE_FCNTL_FILE_POINTER, &file) != SQLITE_OK)
      return fails(sqlite_error(database.get(), path));
    if (file->pMethods->xSync(file, SQLITE_SYNC_NORMAL) == SQLITE_OK) return {};
    int error = 0;
    (void)sqlite3_file_control(database.get(), "main", SQLITE_FCNTL_LAST_ERRNO, &error);
    return fails(path + ": " + std::strerror(error));
  }

  // Moves the log into the database if it is long enough and nobody reads. If the pages cannot be copied, that only
  // costs room: the committed entries are in the log, and the next commit tries again.
  //
  // SQLite would wait for the disk twice, first for the log, which the commit has just synchronized. So it is told to
  // wait for nothing, and the log is emptied only once the database is synchronized here.
  void checkpoint() {
    if (frames >= kCheckpointFrames || stale_log) merge();
  }
  void merge() {
    if (!wal_file)
      if (Result<OpenFile> opened = open_regular(path + "-wal")) wal_file = std::move(*opened);
    const bool alone = wal_file && ::flock(wal_file.get(), LOCK_EX | LOCK_NB) == 0;
    if ((alone || frames >= kMostFrames) && execute(database.get(), kNoWaits) && move_log(SQLITE_CHECKPOINT_FULL)) {
      if (const auto safe = synchronize_database(); !safe) {
        broken = safe.error();
      } else if (move_log(SQLITE_CHECKPOINT_TRUNCATE)) {
        frames = 0;
        stale_log = false;
        new_log = static_cast<bool>(wal_file);
      }
    }
    if (!new_log) wait_again();
    if (alone) ::flock(wal_file.get(), LOCK_UN);
  }
  void wait_again() {
    if (!execute(database.get(), kWaits) && broken.empty()) broken = sqlite_error(database.get(), path);
  }
  // SQLite would wait twice for the first commit of a new log: for the log's header, then for the rest. Once is enough:
  // the header begins the checksums of the frames, so they count only with it.
  [[nodiscard]] bool synchronize_new_log() {
    if (!new_log) return true;
    new_log = false;
    if (::fdatasync(wal_file.get()) != 0)
      broken = path + "-wal: " + std::strerror(errno);
    else
      wait_again();
    return broken.empty();
  }

  // Makes it one file without -wal. SQLite would take ten waits for the disk, and the ledger's next entries wait
  // meanwhile; three are enough, in this order: the database holds all; the log is gone; the database says that it has
  // none. That it says so changes the first 100 bytes of the file, and a sector is written whole or not at all.
  Result<void> leave_log() {
    if (!execute(database.get(), kNoWaits) || !move_log(SQLITE_CHECKPOINT_FULL))
      return fails(sqlite_error(database.get(), path));
    if (auto safe = synchronize_database(); !safe) return safe;
    const std::string log = path + "-wal";
    if ((::unlink(log.c_str()) != 0 && errno != ENOENT) || !synchronize_directory(path))
      return fails(path + ": " + std::strerror(errno));
    if (first_text(database.get(), "PRAGMA journal_mode = MEMORY") != "memory")
      return fails(sqlite_error(database.get(), path));
    // Before it is closed: afterwards somebody else in this process may have it open already, see synchronize().
    Result<void> safe_without_log = synchronize_database();
    database.reset();
    return safe_without_log;
  }
};

ChainWriter::ChainWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ChainWriter::ChainWriter(ChainWriter&&) noexcept = default;
ChainWriter& ChainWriter::operator=(ChainWriter&&) noexcept = default;
ChainWriter::~ChainWriter() = default;

Result<ChainWriter> ChainWriter::create(const std::string& path, ChainSort sort, std::string origin,
                                        const SigningKey& key) {
  if (Result<void> made = make_file(path, sort); !made) return fails(std::move(made.error()));
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->origin = std::move(origin);
  impl->key = key;
  if (Result<void> connected = impl->connect(); !connected) return fails(std::move(connected.error()));
  return ChainWriter(std::move(impl));
}

Result<ChainWriter> ChainWriter::create_ahead(const std::string& path, ChainSort sort) {
  if (Result<void> made = make_file(path, sort); !made) return fails(std::move(made.error()));
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  Result<void> connected = impl->connect();
  std::optional<ChainWriter> writer(ChainWriter(std::move(impl)));
  Result<void> begun = connected ? writer->begin_log() : std::move(connected);
  if (begun) return std::move(*writer);
  writer.reset();
  for (const std::string& own : {path + "-wal", path}) ::unlink(own.c_str());
  return fails(std::move(begun.error()));
}

// A transaction that changes nothing. With it the log's header is on the disk, and so is the log's name.
Result<void> ChainWriter::begin_log() {
  if (execute(impl_->database.get(), ("PRAGMA user_version = " + std::to_string(kFormatVersion)).c_str())) return {};
  return impl_->failed();
}

Result<void> ChainWriter::merge_log() {
  impl_->merge();
  return impl_->broken.empty() ? Result<void>() : fails(impl_->broken);
}

// The log first, so that whoever finds the file finds its log as well.
Result<void> ChainWriter::take_name(const std::string& path, std::string origin, const SigningKey& key) {
  Impl& own = *impl_;
  const std::string log = path + "-wal";
  if (Result<void> there = own.in_its_place(); !there) return there;
  if (::link((own.path + "-wal").c_str(), log.c_str()) != 0) return fails(log + ": " + std::strerror(errno));
  if (::link(own.path.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(log.c_str());
    return fails(path + ": " + std::strerror(error));
  }
  own.path = path;
  own.origin = std::move(origin);
  own.key = key;
  return {};
}

Result<void> ChainWriter::drop_name(const std::string& first, const std::string& kept) {
  if (!synchronize_directory(kept)) return fails(kept + ": " + std::strerror(errno));
  ::unlink((first + "-wal").c_str());
  ::unlink(first.c_str());
  return {};
}

Result<ChainWriter> ChainWriter::open(const std::string& path, ChainSort sort, std::string origin,
                                      const SigningKey& key) {
  return open(path, sort, std::move(origin), key, key.public_key());
}

Result<ChainWriter> ChainWriter::open(const std::string& path, ChainSort sort, std::string origin,
                                      const SigningKey& key, const PublicKey& last, const WhileBusy& busy) {
  Result<ChainWriter> writer = open_without_key(path, sort, std::move(origin), last, busy);
  if (writer) writer->impl_->key = key;
  return writer;
}

Result<ChainWriter> ChainWriter::open_without_key(const std::string& path, ChainSort sort, std::string origin,
                                                  const PublicKey& last, const WhileBusy& busy) {
  if (Result<void> can = may_have_log(path); !can) return tl::unexpected(can.error());
  const Result<ChainTail> tail = follow_chain(path, sort, origin, last);
  if (!tail) return fails(tail.error());
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->origin = std::move(origin);
  impl->pending = impl->committed = *tail;
  if (Result<void> connected = impl->connect(busy); !connected) return fails(std::move(connected.error()));
  // Somebody else may have written since the chain was followed.
  const std::string now =
      first_text(impl->database.get(), "SELECT seq || ' ' || lower(hex(head)) FROM entry ORDER BY seq DESC LIMIT 1");
  if (now.empty() && tail->seq != 0) return fails(sqlite_error(impl->database.get(), path));
  if (now != (tail->seq == 0 ? "" : std::to_string(tail->seq) + " " + hex(tail->head)))
    return fails(path + ": somebody else has just written to it; try again");
  return ChainWriter(std::move(impl));
}

Result<void> ChainWriter::append(std::string_view kind, std::int64_t t_ns, std::string_view body) {
  Impl& own = *impl_;
  if (!own.insert_entry) return fails(own.path + ": is closed");
  if (!own.broken.empty()) return fails(own.broken);
  if (const std::size_t most = most_bytes(kind); body.size() > most) {
    own.roll_back();
    return fails(own.path + ": a " + std::string(kind) + " entry of " + std::to_string(body.size()) +
                 " bytes; at most " + std::to_string(most) + " can be read back");
  }
  if (sqlite3_get_autocommit(own.database.get()) != 0 && !execute(own.database.get(), "BEGIN IMMEDIATE"))
    return own.failed();
  const Entry entry{.seq = own.pending.seq + 1, .kind = std::string(kind), .t_ns = t_ns, .body = std::string(body)};
  const Digest head = next_head(own.pending.head, entry);
  sqlite3_stmt* insert = own.insert_entry.get();
  sqlite3_bind_int64(insert, 1, entry.seq);
  sqlite3_bind_text(insert, 2, entry.kind.data(), static_cast<int>(entry.kind.size()), SQLITE_STATIC);
  sqlite3_bind_int64(insert, 3, entry.t_ns);
  sqlite3_bind_blob64(insert, 4, entry.body.data(), entry.body.size(), SQLITE_STATIC);
  sqlite3_bind_blob(insert, 5, head.data(), static_cast<int>(head.size()), SQLITE_STATIC);
  if (!Impl::run(insert)) return own.failed();
  own.pending.seq = entry.seq;
  own.pending.head = head;
  own.t_ns = t_ns;
  return {};
}

Result<void> ChainWriter::commit() {
  if (impl_->pending.seq == impl_->committed.seq) return {};
  Result<void> done = commit_last();
  if (done) impl_->checkpoint();
  return done;
}

Result<void> ChainWriter::commit_last() {
  Impl& own = *impl_;
  if (own.pending.seq == own.committed.seq) return {};
  if (Result<void> there = own.in_its_place(); !there) {
    own.roll_back();
    return there;
  }
  if (!own.add_note() || !execute(own.database.get(), "COMMIT")) return own.failed();
  if (!own.synchronize_new_log()) {
    own.roll_back();
    return fails(own.broken);
  }
  own.committed = own.pending;
  return {};
}

void ChainWriter::roll_back() { impl_->roll_back(); }

Result<void> ChainWriter::close() {
  Impl& own = *impl_;
  if (!own.database) return {};
  if (Result<void> done = commit_last(); !done) return done;
  own.insert_entry.reset();
  own.insert_note.reset();
  return own.leave_log();
}

bool ChainWriter::in_its_place() const { return impl_->in_its_place().has_value(); }
std::int64_t ChainWriter::committed() const noexcept { return impl_->committed.seq; }
const Digest& ChainWriter::committed_head() const noexcept { return impl_->committed.head; }

}  // namespace dwell::record
