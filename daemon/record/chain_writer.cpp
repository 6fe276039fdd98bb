#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "daemon/record/chain_database.hpp"
#include "daemon/record/chain_file.hpp"
#include "daemon/record/chain_log.hpp"
#include "daemon/record/chain_tables.hpp"
#include "daemon/record/chain_tail.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/sqlite.hpp"

namespace dwell::record {
namespace {

// Largest body of an entry that readers take.
std::size_t most_bytes(std::string_view kind) {
  return kind == "stream" ? static_cast<std::size_t>(ChainReader::kMaxBody) : kMaxJson;
}

}  // namespace

struct ChainWriter::Impl {
  std::string path, origin;
  std::optional<SigningKey> key;  // none: commits carry no note
  ChainLog log{path};
  Database database;
  Statement insert_entry, insert_note;
  ChainTail pending, committed;
  std::int64_t t_ns = 0;  // of the last entry appended
  // Which file it is.
  dev_t device = 0;
  ino_t inode = 0;

  Impl() = default;
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] tl::unexpected<Failure> failed() {
    std::string error = sqlite_error(database.get(), path);
    roll_back();
    return fails(std::move(error));
  }

  Result<void> connect(const WhileBusy& busy = {}) {
    Result<Database> opened = open_chain_database(path, busy);
    if (!opened) return fails(std::move(opened.error()));
    database = std::move(*opened);
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0) return fails(path + ": " + std::strerror(errno));
    device = status.st_dev;
    inode = status.st_ino;
    insert_entry = prepare(database.get(), "INSERT INTO entry (seq, kind, t_ns, body, head) VALUES (?, ?, ?, ?, ?)");
    insert_note = prepare(database.get(), "INSERT INTO note (seq, text) VALUES (?, ?)");
    if (!insert_entry || !insert_note) return fails(sqlite_error(database.get(), path));
    log.attach(database.get());
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
    if (pending.seq != committed.seq) log.mark_stale();
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
};

ChainWriter::ChainWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ChainWriter::ChainWriter(ChainWriter&&) noexcept = default;
ChainWriter& ChainWriter::operator=(ChainWriter&&) noexcept = default;
ChainWriter::~ChainWriter() = default;

Result<ChainWriter> ChainWriter::create(const std::string& path, ChainSort sort, std::string origin,
                                        const SigningKey& key) {
  if (Result<void> made = make_chain_database(path, sort); !made) return fails(std::move(made.error()));
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->origin = std::move(origin);
  impl->key = key;
  if (Result<void> connected = impl->connect(); !connected) return fails(std::move(connected.error()));
  return ChainWriter(std::move(impl));
}

Result<ChainWriter> ChainWriter::create_ahead(const std::string& path, ChainSort sort) {
  if (Result<void> made = make_chain_database(path, sort); !made) return fails(std::move(made.error()));
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
  impl_->log.merge();
  return impl_->log.broken().empty() ? Result<void>() : fails(impl_->log.broken());
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
  if (!own.log.broken().empty()) return fails(own.log.broken());
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
  if (done) impl_->log.checkpoint();
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
  if (!own.log.synchronize()) {
    own.roll_back();
    return fails(own.log.broken());
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
  if (Result<void> left = own.log.leave(); !left) return left;
  own.database.reset();
  return {};
}

bool ChainWriter::in_its_place() const { return impl_->in_its_place().has_value(); }
std::int64_t ChainWriter::committed() const noexcept { return impl_->committed.seq; }
const Digest& ChainWriter::committed_head() const noexcept { return impl_->committed.head; }

}  // namespace dwell::record
