// The newest lines of the log, for those who ask over HTTP: bounded in number and length. Thread-safe; a push takes a
// short lock and allocates.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

namespace dwell {

enum class Level : std::uint8_t { debug, info, warning, error };
[[nodiscard]] const char* to_string(Level level) noexcept;  // "debug", "info", "warning", "error"

struct LogLine {
  std::uint64_t number = 0;  // 1, 2, 3 … since the service began
  std::int64_t utc_ns = 0;
  Level level = Level::info;
  std::string text;
  std::string state{};  // that began, as /api/v1/dwell names it; empty: the line tells of no change of state
};

class NewestLines {
 public:
  // Fewer: an operator who comes back from lunch misses what happened. More: a larger answer, of some 100 bytes a line.
  static constexpr std::size_t kLines = 500;
  // Of one line; the rest is cut off. A dwell of 30 elements has 3 kB.
  static constexpr std::size_t kBytes = 4096;

  // state: as in LogLine.
  void push(Level level, std::string_view text, std::int64_t utc_ns, std::string_view state = {});

  // Oldest first: from a number on, or the newest; at most `count`.
  [[nodiscard]] std::vector<LogLine> from(std::uint64_t number, std::size_t count) const;
  [[nodiscard]] std::vector<LogLine> newest(std::size_t count) const;
  [[nodiscard]] std::uint64_t total() const;

 private:
  mutable std::mutex mutex_;
  std::deque<LogLine> lines_;
  std::uint64_t total_ = 0;
};

}  // namespace dwell
