#include "daemon/log/log.hpp"

#include <spdlog/async.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/sinks/rotating_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <mutex>

#include "daemon/log/journal_sink.hpp"
#include "daemon/log/log_payload.hpp"

namespace dwell {
namespace {

spdlog::level::level_enum to_spdlog(Level level) {
  switch (level) {
    case Level::debug:
      return spdlog::level::debug;
    case Level::info:
      return spdlog::level::info;
    case Level::warning:
      return spdlog::level::warn;
    case Level::error:
      return spdlog::level::err;
  }
  return spdlog::level::err;
}

// Whether the newest line was taken, and why not. Thread-safe.
class FileTrouble {
 public:
  void set(const char* reason) {
    const std::lock_guard lock(mutex_);
    reason_ = reason;
  }
  void clear() {
    const std::lock_guard lock(mutex_);
    reason_.clear();
  }
  [[nodiscard]] std::string reason() const {
    const std::lock_guard lock(mutex_);
    return reason_;
  }

 private:
  mutable std::mutex mutex_;
  std::string reason_;  // empty: it was taken
};

// Shows the message alone to a sink that has no use for fields, and notes what becomes of it.
class WithoutFields final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  WithoutFields(spdlog::sink_ptr inner, std::shared_ptr<FileTrouble> trouble)
      : inner_(std::move(inner)), trouble_(std::move(trouble)) {
    inner_->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ %v");
  }

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::details::log_msg plain = message;
    const std::string_view text = message_of({message.payload.data(), message.payload.size()});
    plain.payload = spdlog::string_view_t(text.data(), text.size());
    try {
      inner_->log(plain);
    } catch (const std::exception& failure) {
      failed_ = true;
      trouble_->set(failure.what());
      throw;
    }
  }
  // After each line: what was only buffered until now is lost here if there is no room.
  void flush_() override {
    const bool failed = std::exchange(failed_, false);
    try {
      inner_->flush();
      if (!failed) trouble_->clear();
    } catch (const std::exception& failure) {
      trouble_->set(failure.what());
      if (!failed) throw;  // one line lost, one failure counted
    }
  }

  spdlog::sink_ptr inner_;
  std::shared_ptr<FileTrouble> trouble_;
  bool failed_ = false;  // the line before this flush
};

}  // namespace

struct Log::Impl {
  NewestLines newest;
  Level level = Level::info;
  std::atomic<std::uint64_t> lines{0};
  std::atomic<std::uint64_t> failed{0};
  std::shared_ptr<FileTrouble> trouble = std::make_shared<FileTrouble>();
  std::shared_ptr<spdlog::details::thread_pool> pool;
  std::shared_ptr<spdlog::async_logger> logger;
};

Log::Log(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Log::~Log() {
  // The pool's thread writes what waits and is joined; only then do the sinks go.
  impl_->pool.reset();
  impl_->logger.reset();
}

tl::expected<std::unique_ptr<Log>, std::string> Log::make(const LogOptions& options) {
  auto impl = std::make_unique<Impl>();
  impl->level = options.level;
  std::vector<spdlog::sink_ptr> sinks;
  try {
    if (options.console && is_journal(std::getenv("JOURNAL_STREAM"), STDERR_FILENO)) {
      sinks.push_back(std::make_shared<JournalSink>());
    } else if (options.console) {
      sinks.push_back(std::make_shared<WithoutFields>(std::make_shared<spdlog::sinks::stderr_color_sink_st>(),
                                                      std::make_shared<FileTrouble>()));
    }
    if (!options.file.empty()) {
      sinks.push_back(std::make_shared<WithoutFields>(
          std::make_shared<spdlog::sinks::rotating_file_sink_st>(options.file, options.file_bytes, options.files),
          impl->trouble));
    }
    impl->pool = std::make_shared<spdlog::details::thread_pool>(options.queue, 1,
                                                                [] { pthread_setname_np(pthread_self(), "log"); });
    impl->logger = std::make_shared<spdlog::async_logger>("dwelld", sinks.begin(), sinks.end(), impl->pool,
                                                          spdlog::async_overflow_policy::overrun_oldest);
    impl->logger->set_level(to_spdlog(options.level));
    impl->logger->flush_on(spdlog::level::debug);
    impl->logger->set_error_handler([counts = impl.get()](const std::string&) { counts->failed.fetch_add(1); });
  } catch (const std::exception& failure) {
    return tl::unexpected("log: " + std::string(failure.what()));
  }
  return std::unique_ptr<Log>(new Log(std::move(impl)));
}

void Log::write(Level level, std::string_view message, std::initializer_list<LogField> fields) noexcept {
  try {
    const std::string payload = make_payload(message, fields);
    impl_->lines.fetch_add(1, std::memory_order_relaxed);
    const auto* const state =
        std::find_if(fields.begin(), fields.end(), [](const LogField& field) { return field.first == kStateField; });
    if (level >= impl_->level)
      impl_->newest.push(level, message_of(payload),
                         std::chrono::nanoseconds(std::chrono::system_clock::now().time_since_epoch()).count(),
                         state != fields.end() ? state->second : std::string_view());
    impl_->logger->log(to_spdlog(level), spdlog::string_view_t(payload.data(), payload.size()));
  } catch (...) {
    impl_->failed.fetch_add(1, std::memory_order_relaxed);
  }
}

LogStats Log::stats() const noexcept {
  LogStats stats;
  stats.lines = impl_->lines.load(std::memory_order_relaxed);
  stats.dropped = impl_->failed.load(std::memory_order_relaxed);
  try {
    stats.reason = impl_->trouble->reason();
    stats.failing = !stats.reason.empty();
    stats.dropped += impl_->pool->overrun_counter();
  } catch (...) {  // NOLINT(bugprone-empty-catch): a lock that fails; the count is then that of the failures alone
  }
  return stats;
}

const NewestLines& Log::newest() const noexcept { return impl_->newest; }

bool is_journal(const char* journal_stream, int descriptor) noexcept {
  if (journal_stream == nullptr) return false;
  const char* const end = journal_stream + std::strlen(journal_stream);
  unsigned long long device = 0;
  unsigned long long inode = 0;
  const auto first = std::from_chars(journal_stream, end, device);
  if (first.ec != std::errc{} || first.ptr == end || *first.ptr != ':') return false;
  const auto second = std::from_chars(first.ptr + 1, end, inode);
  if (second.ec != std::errc{} || second.ptr != end) return false;
  struct stat is {};
  return fstat(descriptor, &is) == 0 && is.st_dev == device && is.st_ino == inode;
}

}  // namespace dwell
