#include "daemon/serve/file_reader.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "daemon/record/regular_file.hpp"

namespace dwell {

// Used by the thread `downloads` alone.
class FileReader::OpenedFile {
 public:
  OpenedFile(record::OpenFile file, const struct stat& status) : file_(std::move(file)), status_(status) {}

  [[nodiscard]] std::uint64_t bytes() const { return static_cast<std::uint64_t>(status_.st_size); }

  std::string next() {
    struct stat now {};
    const bool same = ::fstat(file_.get(), &now) == 0 && now.st_size == status_.st_size &&
                      now.st_mtim.tv_sec == status_.st_mtim.tv_sec && now.st_mtim.tv_nsec == status_.st_mtim.tv_nsec;
    if (!same) return {};
    std::string piece(std::min<std::uint64_t>(kPieceBytes, bytes() - at_), '\0');
    for (std::size_t have = 0; have < piece.size();) {
      const auto got = ::pread(file_.get(), piece.data() + have, piece.size() - have, static_cast<off_t>(at_ + have));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) return {};
      have += static_cast<std::size_t>(got);
    }
    at_ += piece.size();
    return piece;
  }

 private:
  record::OpenFile file_;
  struct stat status_;
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
          if (::stat((path + "-wal").c_str(), &log) == 0 && log.st_size > 0)
            return refused(409, "a part of this run is in a -wal file beside it: expected a run that was closed");
          auto file = record::open_regular(path, O_RDONLY | O_NOFOLLOW);
          if (!file && ::lstat(path.c_str(), &status) != 0 && errno == ENOENT)
            return refused(404, "this run's file is no longer there: it was deleted a moment ago");
          if (!file) return refused(409, "this run's file cannot be read: " + file.error());
          if (::fstat(file->get(), &status) != 0) return refused(409, "this run's file cannot be read");
          auto opened = std::make_shared<OpenedFile>(std::move(*file), status);
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

}  // namespace dwell
