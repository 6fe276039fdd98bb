#include "daemon/record/chain_log.hpp"

#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "daemon/record/chain_database.hpp"

namespace dwell::record {
namespace {

// Frames of the log after which its pages go into the database: 16 MB, some seconds of the largest rig.
constexpr int kCheckpointFrames = 1000;
// The longest log that a reader takes. Then it is moved even while somebody reads, whose reading fails.
constexpr int kMostFrames = static_cast<int>(ChainReader::kMaxWal / kPageBytes);

}  // namespace

void ChainLog::attach(sqlite3* database) {
  database_ = database;
  sqlite3_wal_hook(
      database,
      [](void* own, sqlite3*, const char*, int count) {
        static_cast<ChainLog*>(own)->frames_ = count;
        return SQLITE_OK;
      },
      this);
}

bool ChainLog::move(int mode) {
  return sqlite3_wal_checkpoint_v2(database_, nullptr, mode, nullptr, nullptr) == SQLITE_OK;
}

// Waits until what the database's file holds now survives a loss of power: through SQLite's own descriptor, since
// closing another one would take away its locks (fcntl(2)).
Result<void> ChainLog::synchronize_database() {
  sqlite3_file* file = nullptr;
  if (sqlite3_file_control(database_, "main", SQLITE_FCNTL_FILE_POINTER, &file) != SQLITE_OK)
    return fails(sqlite_error(database_, path_));
  if (file->pMethods->xSync(file, SQLITE_SYNC_NORMAL) == SQLITE_OK) return {};
  int error = 0;
  (void)sqlite3_file_control(database_, "main", SQLITE_FCNTL_LAST_ERRNO, &error);
  return fails(path_ + ": " + std::strerror(error));
}

void ChainLog::checkpoint() {
  if (frames_ >= kCheckpointFrames || stale_) merge();
}

// SQLite would wait for the disk twice, first for the log, which the commit has just synchronized. So it is told to
// wait for nothing, and the log is emptied only once the database is synchronized here.
void ChainLog::merge() {
  if (!file_)
    if (Result<OpenFile> opened = open_regular(path_ + "-wal")) file_ = std::move(*opened);
  const bool alone = file_ && ::flock(file_.get(), LOCK_EX | LOCK_NB) == 0;
  if ((alone || frames_ >= kMostFrames) && execute(database_, kNoWaits) && move(SQLITE_CHECKPOINT_FULL)) {
    if (const auto safe = synchronize_database(); !safe) {
      broken_ = safe.error();
    } else if (move(SQLITE_CHECKPOINT_TRUNCATE)) {
      frames_ = 0;
      stale_ = false;
      new_ = static_cast<bool>(file_);
    }
  }
  if (!new_) wait_again();
  if (alone) ::flock(file_.get(), LOCK_UN);
}

void ChainLog::wait_again() {
  if (!execute(database_, kWaits) && broken_.empty()) broken_ = sqlite_error(database_, path_);
}

// SQLite would wait twice for the first commit of a new log: for the log's header, then for the rest. Once is enough:
// the header begins the checksums of the frames, so they count only with it.
bool ChainLog::synchronize() {
  if (!new_) return true;
  new_ = false;
  if (::fdatasync(file_.get()) != 0)
    broken_ = path_ + "-wal: " + std::strerror(errno);
  else
    wait_again();
  return broken_.empty();
}

// SQLite would take ten waits for the disk; three are enough, in this order: the database holds all; the log is gone;
// the database says that it has none. That it says so changes the first 100 bytes of the file, and a sector is written
// whole or not at all.
Result<void> ChainLog::leave() {
  if (!execute(database_, kNoWaits) || !move(SQLITE_CHECKPOINT_FULL)) return fails(sqlite_error(database_, path_));
  if (auto safe = synchronize_database(); !safe) return safe;
  const std::string log = path_ + "-wal";
  if ((::unlink(log.c_str()) != 0 && errno != ENOENT) || !synchronize_directory(path_))
    return fails(path_ + ": " + std::strerror(errno));
  if (first_text(database_, "PRAGMA journal_mode = MEMORY") != "memory") return fails(sqlite_error(database_, path_));
  // Before the connection is closed: afterwards somebody else in this process may have the file open already.
  return synchronize_database();
}

}  // namespace dwell::record
