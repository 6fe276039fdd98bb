#include "daemon/record/directory_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace dwell::record {

DirectoryLock::~DirectoryLock() {
  if (file_ >= 0) close(file_);
}

Result<void> DirectoryLock::take(const std::string& directory) {
  if (file_ < 0) file_ = open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file_ < 0) return tl::unexpected(directory + ": " + std::strerror(errno));
  if (flock(file_, LOCK_EX | LOCK_NB) == 0) return {};
  return tl::unexpected(directory + ": " +
                        (errno == EWOULDBLOCK ? "another dwelld records here" : std::strerror(errno)));
}

}  // namespace dwell::record
