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
#include <cstdlib>
#include <cstring>

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

// Shows the message alone to a sink that has no use for fields.
class WithoutFields final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
 public:
  explicit WithoutFields(spdlog::sink_ptr inner) : inner_(std::move(inner)) {
    inner_->set_pattern("%Y-%m-%dT%H:%M:%S.%e%z %^%l%$ %v");
  }

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::details::log_msg plain = message;
    const std::string_view text = message_of({message.payload.data(), message.payload.size()});
    plain.payload = spdlog::string_view_t(text.data(), text.size());
    inner_->log(plain);
  }
  void flush_() override { inner_->flush(); }

  spdlog::sink_ptr inner_;
};

}  // namespace

struct Log::Impl {
  std::atomic<std::uint64_t> lines{0};
  std::atomic<std::uint64_t> failed{0};
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
  std::vector<spdlog::sink_ptr> sinks;
  try {
    if (options.console && is_journal(std::getenv("JOURNAL_STREAM"), STDERR_FILENO)) {
      sinks.push_back(std::make_shared<JournalSink>());
    } else if (options.console) {
      sinks.push_back(std::make_shared<WithoutFields>(std::make_shared<spdlog::sinks::stderr_color_sink_st>()));
    }
    if (!options.file.empty()) {
      sinks.push_back(std::make_shared<WithoutFields>(
          std::make_shared<spdlog::sinks::rotating_file_sink_st>(options.file, options.file_bytes, options.files)));
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
    stats.dropped += impl_->pool->overrun_counter();
  } catch (...) {  // NOLINT(bugprone-empty-catch): a lock that fails; the count is then that of the failures alone
  }
  return stats;
}

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
