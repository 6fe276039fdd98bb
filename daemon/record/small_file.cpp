#include "daemon/record/small_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "daemon/record/regular_file.hpp"

namespace dwell::record {
namespace {

tl::unexpected<std::string> failure(const std::string& path) {
  return tl::unexpected(path + ": " + system_text(errno));
}

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

Result<void> write_synchronized(const std::string& path, int flags, std::string_view bytes) {
  const Result<OpenFile> file = open_regular(path, O_WRONLY | O_CREAT | flags);
  if (!file) return tl::unexpected(file.error());
  if (!write_all(file->get(), bytes) || fsync(file->get()) != 0) return failure(path);
  return {};
}

// A full disk may have cut the last line.
bool ends_within_line(const std::string& path) {
  const Result<OpenFile> file = open_regular(path);
  if (!file) return false;
  const off_t size = lseek(file->get(), 0, SEEK_END);
  char last = '\n';
  return size > 0 && pread(file->get(), &last, 1, size - 1) == 1 && last != '\n';
}

}  // namespace

Result<std::string> read_small_file(const std::string& path, std::size_t limit) {
  const Result<OpenFile> file = open_regular(path);
  if (!file) return tl::unexpected(file.error());
  std::string bytes;
  char part[16384];
  for (ssize_t count = 0; (count = read(file->get(), part, sizeof part)) != 0;) {
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failure(path);
    bytes.append(part, static_cast<std::size_t>(count));
    if (bytes.size() > limit) return tl::unexpected(path + ": larger than " + std::to_string(limit) + " bytes");
  }
  return bytes;
}

Result<void> replace_small_file(const std::string& path, std::string_view bytes) {
  const std::string fresh = path + ".new";
  return write_synchronized(fresh, O_TRUNC, bytes).and_then([&] { return rename_durably(fresh, path); });
}

Result<void> append_line(const std::string& path, std::string_view line) {
  return write_synchronized(path, O_APPEND, (ends_within_line(path) ? "\n" : "") + std::string(line) + "\n");
}

Result<void> rename_durably(const std::string& from, const std::string& to) {
  if (std::rename(from.c_str(), to.c_str()) != 0) return failure(to);
  const auto parent = std::filesystem::path(to).parent_path();
  const OpenFile folder(::open(parent.empty() ? "." : parent.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder || fsync(folder.get()) != 0) return failure(to);
  return {};
}

}  // namespace dwell::record
