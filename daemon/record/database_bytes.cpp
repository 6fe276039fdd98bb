#include "daemon/record/database_bytes.hpp"

#include <sqlite3.h>
#include <sys/stat.h>

#include <cerrno>
#include <utility>

#include "daemon/record/regular_file.hpp"

namespace dwell::record {

void DatabaseBytes::Close::operator()(sqlite3_file* file) const noexcept {
  if (file->pMethods != nullptr) file->pMethods->xClose(file);
  sqlite3_free(file);
}

void DatabaseBytes::FreeName::operator()(const char* name) const noexcept { sqlite3_free_filename(name); }

Result<DatabaseBytes> DatabaseBytes::open(const std::string& path) {
  struct stat status {};
  if (::lstat(path.c_str(), &status) != 0) return fails(path + ": " + system_text(errno));
  if (!S_ISREG(status.st_mode)) return fails(path + ": is no regular file");
  sqlite3_vfs* const vfs = sqlite3_vfs_find(nullptr);
  DatabaseBytes bytes;
  bytes.name_.reset(sqlite3_create_filename(path.c_str(), "", "", 0, nullptr));
  bytes.file_.reset(static_cast<sqlite3_file*>(sqlite3_malloc(vfs->szOsFile)));
  if (!bytes.name_ || !bytes.file_) return fails(path + ": out of memory");
  bytes.file_->pMethods = nullptr;
  constexpr int kReadOnly = SQLITE_OPEN_MAIN_DB | SQLITE_OPEN_READONLY | SQLITE_OPEN_NOFOLLOW;
  if (vfs->xOpen(vfs, bytes.name_.get(), bytes.file_.get(), kReadOnly, nullptr) != SQLITE_OK)
    return fails(path + ": cannot be opened: " + system_text(vfs->xGetLastError(vfs, 0, nullptr)));
  sqlite3_int64 size = 0;
  if (bytes.file_->pMethods->xFileSize(bytes.file_.get(), &size) != SQLITE_OK)
    return fails(path + ": its size cannot be read");
  bytes.size_ = static_cast<std::uint64_t>(size);
  return bytes;
}

bool DatabaseBytes::read(std::uint64_t offset, char* to, std::size_t bytes) const noexcept {
  return file_->pMethods->xRead(file_.get(), to, static_cast<int>(bytes), static_cast<sqlite3_int64>(offset)) ==
         SQLITE_OK;
}

}  // namespace dwell::record
