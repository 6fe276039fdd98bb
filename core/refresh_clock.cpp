#include "core/refresh_clock.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

// Jitter of the refresh against the readings, as a part of the interval between readings: at first (30 µs of 2 ms; what
// is less is not told from the stamps' own), and from where on only the two readings are believed.
constexpr double kLeastJitter = 1.0 / 64, kMostJitter = 0.5;
// So many refreshes that fit, and the jitter is taken for half of it again: a foreign reading had made it large.
constexpr int kCalm = 65536;
// By how much a period wanders against the computer's clock in a second: a crystal of 2 ppm a minute, three times over.
constexpr double kWander = 1e-7;
constexpr double kKnown = 0.1;        // of the period, is left open of the instant: then refreshes can be counted
constexpr int kMissed = 16;           // values missed one after the other, while they cannot
constexpr double kLongest_ns = 1e11;  // a period, where nothing is known of it yet

struct Extent {
  double low = INFINITY, high = -INFINITY;
  void see(double x) noexcept { low = std::min(low, x), high = std::max(high, x); }
};

}  // namespace

void RefreshClock::begin(double after, double by) noexcept {
  known_.at[0] = {after, 0.0};
  known_.at[1] = {by, 0.0};
  known_.at[2] = {by, kLongest_ns};
  known_.at[3] = {after, kLongest_ns};
  known_.count = 4;
  since_ = repeats_ = 0;
}

void RefreshClock::clip(Polygon& in, double sign, double bound) noexcept {
  Polygon out;
  for (std::size_t i = 0; i < in.count; ++i) {
    const Vertex &a = in.at[i], &b = in.at[(i + 1) % in.count];
    const double off_a = sign * (a.t - bound), off_b = sign * (b.t - bound);
    if (off_a <= 0) out.at[out.count++] = a;
    if ((off_a < 0 && off_b > 0) || (off_a > 0 && off_b < 0)) {
      const double part = off_a / (off_a - off_b);
      out.at[out.count++] = {bound, a.T + part * (b.T - a.T)};
    }
  }
  in = out;
}

// Leaves out the corners that matter least until there is room for more: what they cut off is a thousandth of what is
// known, or less.
void RefreshClock::thin_out() noexcept {
  while (known_.count > kEnough) {
    std::size_t least = 0;
    double least_area = INFINITY;
    for (std::size_t i = 0; i < known_.count; ++i) {
      const Vertex &a = known_.at[(i + known_.count - 1) % known_.count], &b = known_.at[i],
                   &c = known_.at[(i + 1) % known_.count];
      const double area = std::abs((b.t - a.t) * (c.T - a.T) - (c.t - a.t) * (b.T - a.T));
      if (area < least_area) least_area = area, least = i;
    }
    for (std::size_t i = least; i + 1 < known_.count; ++i) known_.at[i] = known_.at[i + 1];
    --known_.count;
  }
}

void RefreshClock::wander(double elapsed_ns) noexcept {
  Extent T;
  for (std::size_t i = 0; i < known_.count; ++i) T.see(known_.at[i].T);
  const double middle = 0.5 * (T.low + T.high), half = 0.5 * (T.high - T.low);
  const double more = kWander * 1e-9 * elapsed_ns * middle;
  if (!(half > 0)) return;
  for (std::size_t i = 0; i < known_.count; ++i)
    known_.at[i].T = middle + (known_.at[i].T - middle) * (1 + more / half);
}

bool RefreshClock::advance(double refreshes, double after, double by) noexcept {
  Polygon moved = known_;
  for (std::size_t i = 0; i < moved.count; ++i) moved.at[i].t += refreshes * moved.at[i].T;
  clip(moved, 1, by);
  clip(moved, -1, after);
  if (moved.count < 3) return false;
  known_ = moved;
  thin_out();
  return true;
}

RefreshClock::Instant RefreshClock::refreshed(std::int64_t after_ns, std::int64_t by_ns) noexcept {
  const double interval = static_cast<double>(by_ns - after_ns), after = -interval, by = 0.0;  // relative to `by`
  const double elapsed = static_cast<double>(by_ns - origin_ns_);
  const bool repeated = after_ns > origin_ns_;
  origin_ns_ = by_ns;
  jitter_ns_ = std::clamp(jitter_ns_, kLeastJitter * interval, kMostJitter * interval);
  bool fits = known_.count == 0;
  if (fits) begin(after, by);
  if (!fits) {
    wander(elapsed);
    for (std::size_t i = 0; i < known_.count; ++i) known_.at[i].t -= elapsed;
  }
  // Of an interval that holds several refreshes the newest shows, which can be told once the clock is known. Of any
  // other it is the first that fits, since values are seldom missed.
  Extent t, T;
  for (std::size_t i = 0; i < known_.count; ++i) t.see(known_.at[i].t), T.see(known_.at[i].T);
  if (!fits && interval > T.high && t.high - t.low < kKnown * T.low)
    fits = advance(std::max(1.0, std::floor((by - 0.5 * (t.low + t.high)) / (0.5 * (T.low + T.high)))),
                   after - jitter_ns_, by + jitter_ns_);
  for (int refreshes = 1; refreshes <= kMissed && !fits; ++refreshes)
    fits = advance(refreshes, after - jitter_ns_, by + jitter_ns_);
  if (!fits) {
    jitter_ns_ *= 2;
    begin(after, by);
  } else if (++since_ > kCalm) {
    since_ = 0;
    jitter_ns_ *= 0.5;
  }
  if (repeated) ++repeats_;
  t = {};
  for (std::size_t i = 0; i < known_.count; ++i) t.see(known_.at[i].t);
  double low = std::max(after, t.low - jitter_ns_), high = std::min(by, t.high + jitter_ns_);
  if (!(low < high) || !believed() || jitter_ns_ >= kMostJitter * interval) low = after, high = by;
  return {by_ns + std::llround(0.5 * (low + high)), static_cast<std::uint32_t>(std::min(0.5 * (high - low), 4e9))};
}

}  // namespace dwell
