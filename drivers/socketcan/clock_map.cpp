#include "drivers/socketcan/clock_map.hpp"

#include <time.h>

#include <algorithm>
#include <cstdlib>
#include <limits>

namespace dwell::socketcan {
namespace {

// The kernel slews by at most 500 ppm, time daemons by ticks on top of that; what is faster is a step.
constexpr double kFastestSlew = 1e-3;
// Below it the widths of the pairs say more about the rate between two clocks than the slew does.
constexpr std::int64_t kShortest_ns = 1'000'000;
constexpr std::int64_t kResolution_ns = 200;
constexpr int kTries = 5;
constexpr std::int64_t kNarrow_ns = 1'000;

std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec now{};
  ::clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

std::uint32_t half(std::int64_t width_ns) noexcept {
  return static_cast<std::uint32_t>(
      std::clamp<std::int64_t>((width_ns + 1) / 2, 0, std::numeric_limits<std::uint32_t>::max()));
}

// Of instants that may lie anywhere; cut to 70 years either way, so that it can be reckoned with.
std::int64_t distance(std::int64_t a, std::int64_t b) noexcept {
  constexpr std::int64_t kFarthest_ns = INT64_MAX / 4;
  std::int64_t difference = 0;
  if (__builtin_sub_overflow(a, b, &difference)) return a < b ? -kFarthest_ns : kFarthest_ns;
  return std::clamp(difference, -kFarthest_ns, kFarthest_ns);
}

}  // namespace

ClockPair read_clocks() noexcept {
  ClockPair best;
  best.width_ns = std::numeric_limits<std::int64_t>::max();
  for (int i = 0; i < kTries && best.width_ns > kNarrow_ns; ++i) {
    const std::int64_t before_ns = clock_ns(CLOCK_MONOTONIC_RAW);
    const std::int64_t real_ns = clock_ns(CLOCK_REALTIME);
    const std::int64_t width_ns = clock_ns(CLOCK_MONOTONIC_RAW) - before_ns;
    if (width_ns < best.width_ns) best = {before_ns + width_ns / 2, real_ns, width_ns};
  }
  return best;
}

bool ClockMap::plausible(std::int64_t t_ns) const noexcept {
  return t_ns >= empty_.raw_ns - empty_.width_ns - kQueueing_ns && t_ns <= now_.raw_ns + now_.width_ns;
}

Stamp ClockMap::replacement() const noexcept { return {now_.raw_ns, half(2 * (now_.raw_ns - empty_.raw_ns)), true}; }

Stamp ClockMap::map(std::int64_t real_ns) const noexcept {
  if (real_ns <= 0) return replacement();
  const std::int64_t width_ns = std::max(empty_.width_ns, now_.width_ns) + kResolution_ns;
  const std::int64_t span_ns = now_.raw_ns - empty_.raw_ns;
  const std::int64_t moved_ns = distance(now_.real_ns, empty_.real_ns) - span_ns;  // the wall clock against ours
  const std::int64_t since_ns = distance(now_.real_ns, real_ns);
  const auto slewed_ns = static_cast<std::int64_t>(kFastestSlew * static_cast<double>(span_ns));
  if (std::abs(moved_ns) <= slewed_ns + 2 * width_ns) {
    const double rate =
        span_ns < kShortest_ns ? 1.0 : static_cast<double>(span_ns) / static_cast<double>(span_ns + moved_ns);
    if (std::abs(since_ns) > 2 * (span_ns + kQueueing_ns + width_ns)) return replacement();
    const std::int64_t t_ns = now_.raw_ns - static_cast<std::int64_t>(static_cast<double>(since_ns) * rate);
    if (!plausible(t_ns)) return replacement();
    return {std::min(t_ns, now_.raw_ns), half(width_ns), false};
  }
  // Read by the wall clock as it was before the step, and as it has been since. How it was slewed cannot be told.
  const std::int64_t unknown_ns = width_ns + 2 * slewed_ns;
  const std::int64_t after_ns = distance(now_.raw_ns, since_ns);
  const std::int64_t before_ns = distance(empty_.raw_ns, distance(empty_.real_ns, real_ns));
  const bool may_be_after = plausible(after_ns), may_be_before = plausible(before_ns);
  if (may_be_after && may_be_before) {
    const std::int64_t t_ns = std::min(before_ns + (after_ns - before_ns) / 2, now_.raw_ns);
    return {t_ns, half(std::abs(after_ns - before_ns) + unknown_ns), true};
  }
  if (!may_be_after && !may_be_before) return replacement();
  return {std::min(may_be_after ? after_ns : before_ns, now_.raw_ns), half(unknown_ns), false};
}

}  // namespace dwell::socketcan
