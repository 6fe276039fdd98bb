#include "daemon/record/disk_reserve.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>

#include "daemon/record/regular_file.hpp"

namespace dwell::record {

// A sparse file reserves nothing: the blocks must be there.
bool DiskReserve::is_held() const {
  struct stat status {};
  return stat(path_.c_str(), &status) == 0 && status.st_size == bytes_ &&
         std::int64_t{status.st_blocks} * 512 >= bytes_;
}

Result<void> DiskReserve::hold() {
  if (is_held()) return {};
  const Result<OpenFile> file = open_regular(path_, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW, 0600);
  if (!file) return tl::unexpected(file.error());
  const int error = posix_fallocate(file->get(), 0, bytes_);
  if (error == 0) return {};
  release();
  return tl::unexpected(path_ + ": " + system_text(error));
}

void DiskReserve::release() noexcept { unlink(path_.c_str()); }

Result<std::int64_t> free_bytes(const std::string& path) {
  struct statvfs room {};
  if (statvfs(path.c_str(), &room) != 0) return tl::unexpected(path + ": " + system_text(errno));
  return static_cast<std::int64_t>(room.f_bavail) * static_cast<std::int64_t>(room.f_frsize);
}

}  // namespace dwell::record
