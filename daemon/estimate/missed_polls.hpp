// Whether so many polls begin too late that people must be told. Pure: the caller brings the instants.
//
// A computer that does other things as well now and then comes too late to a poll and skips it: the reading is not
// taken, its neighbours are, and no result is wrong by it. That is counted and no news. A device that cannot be polled
// as fast as the rig file asks skips a large part, for as long as it runs: that is.
#pragma once

#include <cstdint>
#include <optional>

namespace dwell {

class MissedPolls {
 public:
  // Looked at over so long: a burst of some seconds (a log being rotated) is no news yet.
  static constexpr std::int64_t kSpan_ns = 60'000'000'000;
  // Part of the polls beyond which people are told: the noise of a result grows by half of it, 5 %. Halved, a busy
  // computer is in the log every day; doubled, a rate that is never reached is not.
  static constexpr double kMany = 0.1;

  // missed: so far, ever growing; rate_hz: polls a second asked for, 0: not known. The part missed since a span ago,
  // once a span, where that is too much.
  std::optional<double> look(std::int64_t now_ns, std::uint64_t missed, double rate_hz) noexcept {
    if (since_ns_ < 0) {
      since_ns_ = now_ns;
      before_ = missed;
    }
    if (now_ns - since_ns_ < kSpan_ns) return std::nullopt;
    const double asked = rate_hz * 1e-9 * static_cast<double>(now_ns - since_ns_);
    const double part = asked > 0.0 ? static_cast<double>(missed - before_) / asked : 0.0;
    since_ns_ = now_ns;
    before_ = missed;
    if (!(part > kMany)) return std::nullopt;
    return part;
  }

 private:
  std::int64_t since_ns_ = -1;
  std::uint64_t before_ = 0;
};

}  // namespace dwell
