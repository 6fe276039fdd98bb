#include "daemon/serve/file_reader.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include "daemon/record/low_priority.hpp"
#include "daemon/record/regular_file.hpp"
#include "daemon/serve/event_loop.hpp"

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

// Outlives the reader where its thread hangs.
struct FileReader::Shared {
  std::mutex mutex;
  EventLoop* loop = nullptr;  // null: the reader is gone
  // Callbacks that wait for an outcome, by number. Used by the loop's thread alone: what they hold must not be
  // destroyed on another thread.
  std::map<std::uint64_t, std::function<void(void*)>> waiting;
};

FileReader::FileReader(EventLoop& loop) : shared_(std::make_shared<Shared>()) { shared_->loop = &loop; }

void FileReader::close() {
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->loop = nullptr;
  }
  std::exchange(shared_->waiting, {}).clear();
}

template <class Work, class Then>
void FileReader::ask(Work work, Then then) {
  using Outcome = decltype(work());
  const std::uint64_t number = next_++;
  shared_->waiting.emplace(
      number, [then = std::move(then)](void* outcome) mutable { then(std::move(*static_cast<Outcome*>(outcome))); });
  if (!thread_) thread_.emplace("downloads");
  thread_->post([shared = shared_, number, work = std::move(work)](const auto&) mutable {
    record::lower_priority();
    auto outcome = std::make_shared<Outcome>(work());
    const std::lock_guard lock(shared->mutex);
    if (shared->loop == nullptr) return;
    shared->loop->post([shared, number, outcome] {
      auto asker = shared->waiting.extract(number);
      if (!asker.empty()) asker.mapped()(outcome.get());
    });
  });
}

void FileReader::open(std::string path, std::function<void(Opening)> done) {
  ask(
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
  ask(
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
