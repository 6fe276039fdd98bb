#include "daemon/record/regular_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace dwell::record {
namespace {

tl::unexpected<std::string> failure(const std::string& path, int error) {
  return tl::unexpected(path + ": " + system_text(error));
}

tl::unexpected<std::string> no_regular_file(const std::string& path) {
  return tl::unexpected(path + ": is no regular file");
}

}  // namespace

std::string system_text(int error) {
  return error == ENOSPC || error == EDQUOT ? "disk full" : std::string(std::strerror(error));
}

OpenFile::OpenFile(OpenFile&& other) noexcept : number_(std::exchange(other.number_, -1)) {}

OpenFile& OpenFile::operator=(OpenFile&& other) noexcept {
  std::swap(number_, other.number_);
  return *this;
}

OpenFile::~OpenFile() {
  if (number_ >= 0) ::close(number_);
}

Result<OpenFile> open_regular(const std::string& path, int flags, mode_t mode) {
  OpenFile file(::open(path.c_str(), (flags & ~O_TRUNC) | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, mode));
  // ENXIO: a socket, or a named pipe that nobody reads.
  if (!file) return errno == ENXIO ? no_regular_file(path) : failure(path, errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return failure(path, errno);
  if (!S_ISREG(status.st_mode)) return no_regular_file(path);
  if ((flags & O_TRUNC) != 0 && ::ftruncate(file.get(), 0) != 0) return failure(path, errno);
  return file;
}

Result<OpenFile> open_regular_if_there(const std::string& path) {
  Result<OpenFile> file = open_regular(path);
  struct stat status {};
  if (!file && ::stat(path.c_str(), &status) != 0 && errno == ENOENT) return OpenFile();
  return file;
}

Result<void> expect_regular(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return failure(path, errno);
  if (!S_ISREG(status.st_mode)) return no_regular_file(path);
  return {};
}

}  // namespace dwell::record
