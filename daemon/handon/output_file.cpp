#include "daemon/handon/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>
#include <utility>

namespace dwell::handon {
namespace {

constexpr std::size_t kBuffer = 1U << 18U;

std::string why() { return std::generic_category().message(errno); }

}  // namespace

record::Result<OutputFile> OutputFile::create(const std::string& path) {
  std::string part = path + ".part";
  const int fd = ::open(part.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (fd < 0) return tl::make_unexpected(path + ": cannot be written: " + why());
  return OutputFile(path, std::move(part), fd);
}

OutputFile::OutputFile(std::string path, std::string part, int fd)
    : path_(std::move(path)), part_(std::move(part)), fd_(fd) {}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : path_(std::move(other.path_)),
      part_(std::move(other.part_)),
      buffer_(std::move(other.buffer_)),
      error_(std::move(other.error_)),
      end_(other.end_),
      fd_(std::exchange(other.fd_, -1)) {}

OutputFile::~OutputFile() {
  if (fd_ < 0) return;
  ::close(fd_);
  ::unlink(part_.c_str());
}

void OutputFile::write(std::string_view bytes) {
  buffer_.append(bytes);
  if (buffer_.size() >= kBuffer) flush();
}

void OutputFile::flush() {
  write_at(end_, buffer_);
  end_ += static_cast<std::int64_t>(buffer_.size());
  buffer_.clear();
}

void OutputFile::write_at(std::int64_t place, std::string_view bytes) {
  while (error_.empty() && !bytes.empty()) {
    const ssize_t written = ::pwrite(fd_, bytes.data(), bytes.size(), place);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      error_ = path_ + ": cannot be written: " + why();
      return;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
    place += written;
  }
}

record::Result<void> OutputFile::keep() {
  flush();
  if (error_.empty() && ::fdatasync(fd_) != 0 && errno != EINVAL) error_ = path_ + ": cannot be written: " + why();
  if (error_.empty() && std::rename(part_.c_str(), path_.c_str()) != 0)
    error_ = path_ + ": cannot be given its name: " + why();
  if (!error_.empty()) return tl::make_unexpected(error_);
  ::close(std::exchange(fd_, -1));
  return {};
}

}  // namespace dwell::handon
