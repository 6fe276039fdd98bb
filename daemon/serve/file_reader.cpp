#include "daemon/serve/file_reader.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "daemon/record/database_bytes.hpp"
#include "daemon/record/file_identity.hpp"

namespace dwell {

// Used by the thread `downloads` alone.
class FileReader::OpenedFile {
 public:
  OpenedFile(std::string path, const record::FileIdentity& identity, record::DatabaseBytes file)
      : path_(std::move(path)), identity_(identity), file_(std::move(file)), bytes_(file_.size()) {}

  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

  std::string next() {
    std::string piece(std::min<std::uint64_t>(kPieceBytes, bytes_ - at_), '\0');
    if (!file_.read(at_, piece.data(), piece.size())) return {};
    // After it was read, so that no change of it is missed. A file that was removed goes on as it was.
    struct stat status {};
    const bool removed = ::lstat(path_.c_str(), &status) != 0 && errno == ENOENT;
    if (!removed && record::identity_of(path_) != identity_) return {};
    at_ += piece.size();
    return piece;
  }

 private:
  const std::string path_;
  const record::FileIdentity identity_;
  const record::DatabaseBytes file_;
  const std::uint64_t bytes_;
  std::uint64_t at_ = 0;
};

namespace {

using Opening = tl::expected<FileReader::Opened, HttpReply>;

tl::unexpected<HttpReply> refused(int status, std::string_view why) { return tl::unexpected(http_error(status, why)); }

}  // namespace

FileReader::FileReader(EventLoop& loop) : aside_(loop, "downloads") {}

void FileReader::open(std::string path, std::function<void(Opening)> done) {
  aside_.ask(
      [path = std::move(path)]() -> Opening {
        try {
          struct stat status {
          }, log{};
          const record::FileIdentity identity = record::identity_of(path);
          if (::stat((path + "-wal").c_str(), &log) == 0 && log.st_size > 0)
            return refused(409, "a part of this run is in a -wal file beside it: expected a run that was closed");
          auto file = record::DatabaseBytes::open(path);
          if (!file && ::lstat(path.c_str(), &status) != 0 && errno == ENOENT)
            return refused(404, "this run's file is no longer there: it was deleted a moment ago");
          if (!file) return refused(409, "this run's file cannot be read: " + file.error());
          auto opened = std::make_shared<OpenedFile>(path, identity, std::move(*file));
          const std::uint64_t bytes = opened->bytes();
          return Opened{std::move(opened), bytes};
        } catch (const std::exception&) {
          return refused(500, "this run's file could not be opened");
        }
      },
      std::move(done));
}

void FileReader::read(const std::shared_ptr<OpenedFile>& file, std::function<void(std::string)> done) {
  aside_.ask(
      [file]() -> std::string {
        try {
          std::string piece = file->next();
          std::this_thread::sleep_for(
              std::chrono::duration<double>(static_cast<double>(piece.size()) / kBytesPerSecond));
          return piece;
        } catch (const std::exception&) {
          return {};
        }
      },
      std::move(done));
}

void FileReader::forget(std::shared_ptr<OpenedFile> file) { aside_.drop(std::move(file)); }

}  // namespace dwell
