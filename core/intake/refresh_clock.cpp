#include "core/intake/refresh_clock.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

// Jitter of the refreshes against the readings, as a part of the usual polling interval. The least is assumed at first:
// 30 µs of 2 ms cannot be told from the stamps' own jitter. From the most on only the two readings are used.
constexpr double kLeastJitter = 1.0 / 64, kMostJitter = 0.5;
// Largest part of the usual interval by which one interval changes it. A gap then widens the jitter by 6 % for one
// refresh; a usual interval learned from a gap of 50 intervals is right after 60 refreshes. Half as much doubles the
// latter.
constexpr double kOneInterval = 1.0 / 16;
// Refreshes that fit before the jitter is halved again: a foreign reading may have doubled it.
constexpr int kCalm = 65536;
// Relative wander of a period against the computer's clock in 1 s: three times that of a crystal of 2 ppm a minute.
constexpr double kWander = 1e-7;
constexpr double kKnownTo = 0.1;      // of the period: if the instant is known better, refreshes can be counted
constexpr int kMissed = 16;           // consecutive values that may be missed, if they cannot be counted
constexpr double kLongest_ns = 1e11;  // of a period not known yet

struct Extent {
  double low = INFINITY, high = -INFINITY;
  void see(double x) noexcept { low = std::min(low, x), high = std::max(high, x); }
};

}  // namespace

bool RefreshClock::believed() const noexcept { return repeats_ >= kBelieved && jitter_ < kMostJitter; }

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
    if (off_a <= 0) out.keep(a);
    if ((off_a < 0 && off_b > 0) || (off_a > 0 && off_b < 0)) {
      const double part = off_a / (off_a - off_b);
      out.keep({bound, a.T + part * (b.T - a.T)});
    }
  }
  in = out;
}

// Removes edges until there is room: the neighbours of an edge are extended until they meet. No solution is lost. The
// edge whose removal adds the least area goes first.
void RefreshClock::thin_out() noexcept {
  while (known_.count > kEnough) {
    const std::size_t n = known_.count;
    std::size_t least = n;
    double least_area = INFINITY;
    Vertex meet{};
    for (std::size_t i = 0; i < n; ++i) {
      const Vertex &a = known_.at[(i + n - 1) % n], &b = known_.at[i], &c = known_.at[(i + 1) % n],
                   &d = known_.at[(i + 2) % n];
      const Vertex in{b.t - a.t, b.T - a.T}, edge{c.t - b.t, c.T - b.T}, out{d.t - c.t, d.T - c.T};
      // The neighbours meet at b + along·in = c - back·out.
      const double turn = in.t * out.T - in.T * out.t;
      const double along = (edge.t * out.T - edge.T * out.t) / turn, back = (in.t * edge.T - in.T * edge.t) / turn;
      const double area = along * std::abs(in.t * edge.T - in.T * edge.t);
      if (along >= 0 && back >= 0 && area < least_area)
        least_area = area, least = i, meet = {b.t + along * in.t, b.T + along * in.T};
    }
    if (least == n) return enclose(known_);
    known_.at[least] = meet;
    const std::size_t gone = (least + 1) % n;
    for (std::size_t i = gone; i + 1 < n; ++i) known_.at[i] = known_.at[i + 1];
    --known_.count;
  }
}

// Replaces a polygon by its bounding box.
void RefreshClock::enclose(Polygon& what) noexcept {
  Extent t, T;
  for (std::size_t i = 0; i < what.count; ++i) t.see(what.at[i].t), T.see(what.at[i].T);
  what.at[0] = {t.low, T.low};
  what.at[1] = {t.high, T.low};
  what.at[2] = {t.high, T.high};
  what.at[3] = {t.low, T.high};
  what.count = 4;
}

// The period may have changed by ± more: the Minkowski sum with that interval of T. The lower side, which runs towards
// larger t, goes down, the upper side goes up, and the two outermost corners become edges.
void RefreshClock::wander(double elapsed_ns) noexcept {
  Extent T;
  for (std::size_t i = 0; i < known_.count; ++i) T.see(known_.at[i].T);
  const double more = kWander * 1e-9 * elapsed_ns * 0.5 * (T.low + T.high);
  const std::size_t n = known_.count;
  Polygon out;
  for (std::size_t i = 0; i < n; ++i) {
    const Vertex& at = known_.at[i];
    const double in_t = at.t - known_.at[(i + n - 1) % n].t, out_t = known_.at[(i + 1) % n].t - at.t;
    const bool lower = in_t > 0 || out_t > 0, upper = in_t < 0 || out_t < 0;
    const Vertex down{at.t, at.T - more}, up{at.t, at.T + more};
    if (upper && out_t >= 0) out.keep(up);
    if (lower) out.keep(down);
    if (upper && out_t < 0) out.keep(up);
  }
  known_ = out;
}

bool RefreshClock::advance(double refreshes, double after, double by) noexcept {
  Polygon moved = known_;
  for (std::size_t i = 0; i < moved.count; ++i) moved.at[i].t += refreshes * moved.at[i].T;
  clip(moved, 1, by);
  clip(moved, -1, after);
  Extent t;
  for (std::size_t i = 0; i < moved.count; ++i) t.see(moved.at[i].t);
  if (moved.count < 3 || !(t.low < t.high)) return false;
  known_ = moved;
  thin_out();
  return true;
}

// The interval holds at least one whole period, but the number is unknown. So the newest refresh is at most one period
// before the reading at `by_ns`, to which t is relative. The bounds on the period stay.
void RefreshClock::lose_count(double interval, double jitter) noexcept {
  Extent T;
  for (std::size_t i = 0; i < known_.count; ++i) T.see(std::max(0.0, known_.at[i].T));
  known_.at[0] = {-T.low - jitter, T.low};
  known_.at[1] = {jitter, T.low};
  known_.at[2] = {jitter, T.high};
  known_.at[3] = {-T.high - jitter, T.high};
  known_.count = 4;
  clip(known_, -1, -interval - jitter);
}

RefreshClock::Instant RefreshClock::refreshed(std::int64_t after_ns, std::int64_t by_ns) noexcept {
  const double interval = static_cast<double>(by_ns - after_ns);
  const double elapsed = static_cast<double>(by_ns - origin_ns_);
  const bool repeated = after_ns > origin_ns_;
  origin_ns_ = by_ns;
  if (known_.count == 0) usual_ns_ = interval, jitter_ = kLeastJitter;
  usual_ns_ += std::clamp(interval - usual_ns_, -kOneInterval * usual_ns_, kOneInterval * usual_ns_);
  double jitter_ns = jitter_ * usual_ns_;
  double after = -interval - jitter_ns, by = jitter_ns;  // the relaxed bounds, relative to by_ns
  bool fits = known_.count == 0;
  if (fits) begin(after, by);
  if (!fits) {
    wander(elapsed);
    for (std::size_t i = 0; i < known_.count; ++i) known_.at[i].t -= elapsed;
    Extent t, T;
    for (std::size_t i = 0; i < known_.count; ++i) t.see(known_.at[i].t), T.see(known_.at[i].T);
    // Refreshes since the one before, up to the first after the reading at after_ns.
    const double first = std::max(1.0, std::ceil((after - t.high) / T.high));
    const auto counts = [&](double refreshes) {
      return t.high - t.low + refreshes * (T.high - T.low) < kKnownTo * T.low;
    };
    if (interval > T.high) {
      // Several refreshes, or a gap in polling; the newest value shows. If a refresh may be as near to the reading as
      // the jitter, it is unclear which one that is.
      const double middle_t = 0.5 * (t.low + t.high), middle_T = 0.5 * (T.low + T.high);
      const double near = 0.5 * (t.high - t.low) + jitter_ns;
      const double passed = std::floor(-(middle_t + near) / middle_T);
      const bool clear = passed == std::floor(-(middle_t - near) / middle_T);
      fits = clear && counts(passed) && advance(std::max(1.0, passed), after, by);
      // Repeats during more periods than values may be missed contradict the period.
      if (!fits && first <= kMissed) lose_count(interval, jitter_ns), fits = true;
    } else if (first <= kMissed || counts(first)) {
      // The first number that fits, since values are seldom missed. Larger ones brought the same value while the rig
      // stood still.
      const double from = first <= kMissed ? 1.0 : first;
      for (int more = 0; more < kMissed && !fits; ++more) fits = advance(from + more, after, by);
    } else {
      begin(after, by);  // the rig stood still too long to count; this says nothing of the jitter
      fits = true;
    }
  }
  if (!fits) {
    jitter_ = std::min(2 * jitter_, kMostJitter);
    jitter_ns = jitter_ * usual_ns_;
    after = -interval - jitter_ns, by = jitter_ns;
    begin(after, by);
  } else if (++since_ > kCalm) {
    since_ = 0;
    jitter_ = std::max(0.5 * jitter_, kLeastJitter);
  }
  if (repeated) ++repeats_;
  Extent t;
  for (std::size_t i = 0; i < known_.count; ++i) t.see(known_.at[i].t);
  double low = std::max(-interval, t.low - jitter_ns), high = std::min(0.0, t.high + jitter_ns);
  if (!(low < high) || !believed()) low = -interval, high = 0.0;
  return {by_ns + std::llround(0.5 * (low + high)), static_cast<std::uint32_t>(std::min(0.5 * (high - low), 4e9))};
}

}  // namespace dwell
