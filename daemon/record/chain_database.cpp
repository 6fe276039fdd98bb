#include "daemon/record/chain_database.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "daemon/record/chain_tables.hpp"

namespace dwell::record {
namespace {

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

Database opened(const std::string& path, int flags) {
  sqlite3* database = nullptr;
  sqlite3_open_v2(path.c_str(), &database, flags | SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX, nullptr);
  if (database != nullptr) sqlite3_extended_result_codes(database, 0);
  return Database(database);
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

}  // namespace

Result<void> make_chain_database(const std::string& path, ChainSort sort) {
  const std::string unfinished = path + ".new";
  std::error_code ignored;
  if (std::filesystem::exists(std::filesystem::symlink_status(path, ignored))) return fails(path + ": exists already");
  // A crash during an earlier try leaves files. SQLite would read the old log into the new file.
  for (const std::string& old :
       {unfinished, unfinished + "-journal", unfinished + "-wal", path + "-wal", path + "-shm", path + "-journal"})
    std::filesystem::remove(old, ignored);
  const std::string set =
      "PRAGMA page_size = " + std::to_string(kPageBytes) +
      "; PRAGMA locking_mode = EXCLUSIVE; PRAGMA synchronous = OFF; PRAGMA journal_mode = MEMORY; BEGIN; "
      "PRAGMA application_id = " +
      std::to_string(static_cast<std::uint32_t>(sort)) + "; PRAGMA user_version = " + std::to_string(kFormatVersion) +
      "; " + kEntryTable + "; " + kNoteTable + "; COMMIT";
  Database database = opened(unfinished, SQLITE_OPEN_CREATE);
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

Result<Database> open_chain_database(const std::string& path, const WhileBusy& busy) {
  Database database = opened(path, 0);
  if (!database || !while_busy(database.get(), busy, set_up)) return fails(sqlite_error(database.get(), path));
  return database;
}

Result<void> may_have_log(const std::string& path) {
  const std::string log = path + "-wal";
  struct stat status {};
  if (::lstat(log.c_str(), &status) == 0)
    return S_ISREG(status.st_mode) ? Result<void>() : fails(log + ": is no regular file");
  const std::string folder = std::filesystem::path(path).parent_path().string();
  if (::access(folder.empty() ? "." : folder.c_str(), W_OK | X_OK) == 0) return {};
  return fails(path + ": a log beside it is needed, and no file can be made there: " + std::strerror(errno));
}

bool synchronize_directory(const std::string& path) {
  const std::string directory = std::filesystem::path(path).parent_path().string();
  return synchronize(directory.empty() ? "." : directory, O_DIRECTORY);
}

}  // namespace dwell::record
