#include "daemon/log/newest_lines.hpp"

#include <algorithm>

namespace dwell {

const char* to_string(Level level) noexcept {
  switch (level) {
    case Level::debug:
      return "debug";
    case Level::info:
      return "info";
    case Level::warning:
      return "warning";
    case Level::error:
      return "error";
  }
  return "?";
}

void NewestLines::push(Level level, std::string_view text, std::int64_t utc_ns, std::string_view state) {
  std::string kept(text.substr(0, kBytes));
  if (text.size() > kBytes) {
    // Not within a character of several bytes.
    while (!kept.empty() && (static_cast<unsigned char>(text[kept.size()]) & 0xC0U) == 0x80U) kept.pop_back();
    kept += "…";
  }
  const std::lock_guard lock(mutex_);
  lines_.push_back({++total_, utc_ns, level, std::move(kept), std::string(state)});
  if (lines_.size() > kLines) lines_.pop_front();
}

std::vector<LogLine> NewestLines::from(std::uint64_t number, std::size_t count) const {
  const std::lock_guard lock(mutex_);
  const auto first =
      std::find_if(lines_.begin(), lines_.end(), [number](const LogLine& line) { return line.number >= number; });
  const auto there = static_cast<std::size_t>(lines_.end() - first);
  return {first, first + static_cast<std::ptrdiff_t>(std::min(count, there))};
}

std::vector<LogLine> NewestLines::newest(std::size_t count) const {
  const std::lock_guard lock(mutex_);
  return {lines_.end() - static_cast<std::ptrdiff_t>(std::min(count, lines_.size())), lines_.end()};
}

std::uint64_t NewestLines::total() const {
  const std::lock_guard lock(mutex_);
  return total_;
}

}  // namespace dwell
