#include "core/stream/loss_judge.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/stream/arrival_grid.hpp"

namespace dwell {
namespace {

// Periods: half a period within the ends of the histogram of delays. Beyond, a delay explains nothing.
constexpr double kFarLate = DelayShape::kLatest - 0.5, kFarEarly = DelayShape::kEarliest + 0.5;
constexpr double kFarPaced = 8.0;    // paced periods after which it is no stall
constexpr double kMostPaced = 32.0;  // paced periods after which waiting brings no more evidence
constexpr double kMostLost = 0.3;
constexpr double kMostTooEarly = 8.0;

// One number of readings lost (or counted too many), and the cumulative sum of the evidence for it.
struct Case {
  int lost;
  double evidence = 0.0;    // nats
  std::size_t against = 0;  // the readings before this one speak against it
  std::size_t since = 0;    // the reading from which the loss is counted

  // The i-th reading speaks for it by `gain`, nats. pace: its distance from the one before, in periods, at most 1.
  void add(std::size_t i, double gain, double pace) noexcept {
    // All readings of a bunch but the first are late for the same reason: only pace counts. On time is always evidence.
    if (gain > 0.0) gain *= pace;
    // The loss is dated midway through the readings that fit both explanations.
    if (gain > 0.0 && evidence == 0.0) since = (against + i + 1) / 2;
    evidence = std::max(0.0, evidence + gain);
    if (gain < 0.0 && evidence == 0.0) against = since = i + 1;
  }
};

}  // namespace

void LossJudge::begin(const ArrivalGrid& grid, std::int64_t newest_ns) noexcept {
  shape_ = grid.shape;
  previous_arrival_ns_ = newest_ns;
  lost_part_ = grid.lost;
  too_early_ = 0.0;
}

LossJudge::Verdict LossJudge::judge(const HeldArrivals& held, const ClockTracker& clock, bool at_once) const noexcept {
  std::array<Case, 5> cases{Case{-2}, Case{-1}, Case{1}, Case{2}, Case{3}};
  const std::size_t count = held.waiting();
  const double threshold = kLossPrice - std::log(std::clamp(lost_part_, 1e-4, 0.1));
  double least = std::numeric_limits<double>::infinity(), paced = 0.0;
  const Case* best = cases.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t arrival_ns = held.arrival_ns(i),
                       before_ns = i > 0 ? held.arrival_ns(i - 1) : previous_arrival_ns_;
    const double pace = std::min(1.0, static_cast<double>(arrival_ns - before_ns) / clock.period_ns());
    if (i > 0) paced += pace;
    const double late = clock.deviation(arrival_ns, i + 1);
    if (late < kFarEarly) return {i, static_cast<int>(std::lround(std::max(late, -1e6)))};
    least = std::min(least, late);
    const double as_it_is = shape_.log_likelihood(late);
    for (Case& c : cases) {
      c.add(i, shape_.log_likelihood(late - c.lost) - as_it_is, pace);
      if (c.evidence > best->evidence) best = &c;
    }
    if (best->evidence <= threshold) continue;
    // Of two losses in short succession the first is told first.
    for (const Case& c : cases)
      if (c.evidence > kLossPrice && c.lost > 0 && c.since < best->since) best = &c;
    return {best->since, best->lost};
  }
  const bool last_chance = at_once || count == HeldArrivals::kCapacity;
  if (least > kFarLate) {
    if (paced < kFarPaced && !last_chance) return {};
    if (4.0 * paced < static_cast<double>(count - 1)) return {count, 0};  // a bunch: delayed, not lost
    return {0, static_cast<int>(std::min(least, 1e6))};
  }
  if (!last_chance && paced < kMostPaced) {
    std::size_t undecided = count;
    for (const Case& c : cases) undecided = std::min(undecided, c.against);
    return {undecided, 0};
  }
  if (best->evidence > kLossPrice) return {best->since, best->lost};
  return {count, 0};
}

void LossJudge::learn(std::int64_t arrival_ns, double late) noexcept {
  shape_.add(late);
  previous_arrival_ns_ = arrival_ns;
  lost_part_ -= lost_part_ / 256.0;
  too_early_ -= too_early_ / 4096.0;
}

void LossJudge::count(int lost) noexcept {
  if (lost > 0) {
    lost_part_ += 1.0 / 256.0;
    too_early_ = std::max(0.0, too_early_ - lost);
  } else {
    too_early_ -= lost;
  }
}

bool LossJudge::implausible() const noexcept { return lost_part_ > kMostLost || too_early_ > kMostTooEarly; }

}  // namespace dwell
