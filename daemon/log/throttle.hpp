// Lets one line through, counts what follows it too closely. Pure: the caller brings the instants.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

namespace dwell {

// The first occurrence passes; then at most one a second, and for as long as it goes on ever more rarely, down to one a
// minute; after a quiet minute it starts anew. Bound to one thread.
class Throttle {
 public:
  // `occurrences` more at now_ns. The number this line stands for, those kept back before it included; nullopt: keep
  // quiet.
  std::optional<std::uint64_t> admit(std::int64_t now_ns, std::uint64_t occurrences = 1) noexcept {
    if (occurrences > 0) {
      if (now_ns - last_seen_ns_ > kLongest_ns) spacing_ns_ = 0;
      last_seen_ns_ = now_ns;
      pending_ += occurrences;
    }
    if (pending_ == 0 || (spacing_ns_ > 0 && now_ns - last_line_ns_ < spacing_ns_)) return std::nullopt;
    last_line_ns_ = now_ns;
    spacing_ns_ = std::clamp(2 * spacing_ns_, kShortest_ns, kLongest_ns);
    const std::uint64_t stands_for = pending_;
    pending_ = 0;
    return stands_for;
  }

 private:
  static constexpr std::int64_t kShortest_ns = 1'000'000'000;
  static constexpr std::int64_t kLongest_ns = 60'000'000'000;
  std::int64_t last_seen_ns_ = 0;
  std::int64_t last_line_ns_ = 0;
  std::int64_t spacing_ns_ = 0;
  std::uint64_t pending_ = 0;
};

}  // namespace dwell
