#include "core/stream/device_clock.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace dwell {
namespace {

constexpr double kNsPerS = 1e9;
constexpr std::size_t kShortStretch = 64;            // enough where jitter is small against the period
constexpr std::uint64_t kFirstPause = 256;           // arrivals between attempts that failed, doubling …
constexpr std::uint64_t kLongestPause = 65536;       // … so that a source without a rate costs nothing
constexpr std::int64_t kSilence_ns = 1'000'000'000;  // after such a pause the device may have been restarted
constexpr double kSilentPeriods = 64.0;
constexpr double kRejection = 6.0;     // mean absolute deviations beyond which an arrival does not move the clock
constexpr double kLeastSpread = 1e-4;  // periods
constexpr double kDoubt = 3.0;         // nats of evidence beyond what the rarity of losses asks for
constexpr double kFarLate = 3.5;       // periods: too late for the shape to tell
constexpr double kFarEarly = -2.5;     // periods: earlier than any delay explains
constexpr double kFarPaced = 8.0;      // periods after which it is no stall
constexpr double kMostPaced = 32.0;    // periods after which more evidence is not to be expected
constexpr double kMostLost = 0.3;
constexpr double kMostTooEarly = 8.0;
constexpr double kMostMistrusted = 0.4;

}  // namespace

DeviceClock::DeviceClock(double nominal_rate_hz) noexcept
    : nominal_ns_(nominal_rate_hz > 0.0 ? kNsPerS / nominal_rate_hz : 0.0), next_pause_(kFirstPause) {}

void DeviceClock::arrive(std::int64_t arrival_ns) noexcept {
  if (any_) {
    arrival_ns = std::max(arrival_ns, last_arrival_ns_);
    const double silence_ns = std::max(static_cast<double>(kSilence_ns), kSilentPeriods * period_ns_);
    if (locked_ && static_cast<double>(arrival_ns - last_arrival_ns_) > silence_ns) unlock();
  }
  any_ = true;
  last_arrival_ns_ = arrival_ns;
  if (count_ == kHeld) decide_all();
  if (count_ == kHeld) {  // the caller does not take what is decided
    first_ = (first_ + 1) % kHeld;
    --count_;
    --decided_;
  }
  Held& reading = held(count_++);
  reading.arrival_ns = arrival_ns;
  if (!locked_) {
    reading.instant = {arrival_ns, 0, false};
    last_given_ns_ = arrival_ns;
    ++decided_;
    acquire(arrival_ns);
    return;
  }
  weigh(false);
  if (mistrusted_ > kMostMistrusted) {
    nominal_ns_ = 0.0;
    unlock();
  }
}

void DeviceClock::wait(std::int64_t now_ns) noexcept {
  if (waiting() > 0 && now_ns - held(decided_).arrival_ns > kLongestHold_ns) weigh(true);
}

void DeviceClock::decide_all() noexcept {
  if (waiting() > 0) weigh(true);
}

bool DeviceClock::next(Instant& out) noexcept {
  if (decided_ == 0) return false;
  out = held(0).instant;
  first_ = (first_ + 1) % kHeld;
  --count_;
  --decided_;
  return true;
}

ClockFigures DeviceClock::figures() const noexcept {
  ClockFigures figures;
  figures.lost = lost_;
  figures.relocked = relocked_;
  figures.locked = locked_;
  if (!locked_) return figures;
  figures.rate_hz = kNsPerS / period_ns_;
  figures.jitter_s = std::sqrt(variance_) * period_ns_ / kNsPerS;
  return figures;
}

double DeviceClock::deviation(std::size_t i) noexcept {
  const double since_ns = static_cast<double>(held(decided_ + i).arrival_ns - whole_ns_) - part_ns_;
  return since_ns / period_ns_ - static_cast<double>(i + 1);
}

// Cumulative sums of the evidence for each number of readings that may have been lost (or counted too many).
DeviceClock::Verdict DeviceClock::judge(bool at_once) noexcept {
  struct Case {
    int lost;
    double evidence = 0.0;    // nats
    std::size_t against = 0;  // up to here it speaks against
    std::size_t since = 0;    // from here on it is counted
  };
  std::array<Case, 5> cases{Case{-2}, Case{-1}, Case{1}, Case{2}, Case{3}};
  const std::size_t count = waiting();
  const double threshold = kDoubt - std::log(std::clamp(lost_part_, 1e-4, 0.1));
  double least = std::numeric_limits<double>::infinity(), paced = 0.0;
  const Case* best = cases.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t before_ns = i > 0 ? held(decided_ + i - 1).arrival_ns : previous_arrival_ns_;
    const double pace = std::min(1.0, static_cast<double>(held(decided_ + i).arrival_ns - before_ns) / period_ns_);
    if (i > 0) paced += pace;
    const double late = deviation(i);
    if (late < kFarEarly) return {i, static_cast<int>(std::lround(std::max(late, -1e6)))};
    least = std::min(least, late);
    const double as_it_is = shape_.log_likelihood(late);
    for (Case& c : cases) {
      double gain = shape_.log_likelihood(late - c.lost) - as_it_is;
      // Of those that arrive in a bunch all but the first are late for the same reason; on time is on time.
      if (gain > 0.0) gain *= pace;
      // In the middle of those that do not tell.
      if (gain > 0.0 && c.evidence == 0.0) c.since = (c.against + i + 1) / 2;
      c.evidence = std::max(0.0, c.evidence + gain);
      if (gain < 0.0 && c.evidence == 0.0) c.against = c.since = i + 1;
      if (c.evidence > best->evidence) best = &c;
    }
    if (best->evidence <= threshold) continue;
    // Two losses in short succession: the first one first.
    for (const Case& c : cases)
      if (c.evidence > kDoubt && c.lost > 0 && c.since < best->since) best = &c;
    return {best->since, best->lost};
  }
  const bool last_chance = at_once || count == kHeld;
  if (least > kFarLate) {
    if (paced < kFarPaced && !last_chance) return {};
    if (4.0 * paced < static_cast<double>(count - 1)) return {count, 0};  // a bunch: held up, not lost
    return {0, static_cast<int>(std::min(least, 1e6))};
  }
  if (!last_chance && paced < kMostPaced) {
    std::size_t undecided = count;
    for (const Case& c : cases) undecided = std::min(undecided, c.against);
    return {undecided, 0};
  }
  if (best->evidence > kDoubt) return {best->since, best->lost};
  return {count, 0};
}

void DeviceClock::weigh(bool at_once) noexcept {
  while (waiting() > 0) {
    const Verdict verdict = judge(at_once);
    if (verdict.settled == 0 && verdict.lost == 0) return;
    commit(verdict.settled);
    if (verdict.lost == 0) continue;
    shift(verdict.lost);
    if (verdict.lost > 0) {
      lost_ += static_cast<std::uint64_t>(verdict.lost);
      lost_part_ += 1.0 / 256.0;
      after_loss_ = true;
      too_early_ = std::max(0.0, too_early_ - verdict.lost);
    } else {
      lost_ -= std::min<std::uint64_t>(lost_, static_cast<std::uint64_t>(-verdict.lost));
      doubt_ = -verdict.lost;
      too_early_ -= verdict.lost;
    }
    if (lost_part_ > kMostLost || too_early_ > kMostTooEarly) {
      nominal_ns_ = 0.0;
      unlock();
      return;
    }
  }
}

void DeviceClock::shift(double periods) noexcept { part_ns_ += periods * period_ns_; }

void DeviceClock::commit(std::size_t count) noexcept {
  for (; count > 0; --count) commit_one(held(decided_++));
}

void DeviceClock::commit_one(Held& reading) noexcept {
  part_ns_ += period_ns_;
  const double late = (static_cast<double>(reading.arrival_ns - whole_ns_) - part_ns_) / period_ns_;
  const double limit = std::max(kRejection * spread_, 10.0 * kLeastSpread);

  age_ = std::min(age_ + 1.0, 3.0 * memory_);
  if (std::abs(late) <= limit) {
    const double theta = 1.0 - 1.0 / memory_;
    const double alpha = std::max((4.0 * age_ - 2.0) / (age_ * (age_ + 1.0)), 1.0 - theta * theta);
    const double beta = std::max(6.0 / (age_ * (age_ + 1.0)), (1.0 - theta) * (1.0 - theta));
    part_ns_ += alpha * late * period_ns_;
    period_ns_ += beta * late * period_ns_;
    if (nominal_ns_ > 0.0) {
      const double tracked_ns = period_ns_;
      period_ns_ = std::clamp(tracked_ns, nominal_ns_ * (1.0 - kNominalRange), nominal_ns_ * (1.0 + kNominalRange));
      mistrusted_ += ((period_ns_ == tracked_ns ? 0.0 : 1.0) - mistrusted_) / memory_;
    }
  }
  shape_.add(late);
  previous_arrival_ns_ = reading.arrival_ns;
  spread_ = std::max(kLeastSpread, spread_ + (std::min(std::abs(late), limit) - spread_) / 256.0);
  variance_ += (late * late - variance_) / std::min(age_, memory_);
  lost_part_ -= lost_part_ / 256.0;
  too_early_ -= too_early_ / 4096.0;

  const double whole = std::floor(part_ns_);
  whole_ns_ += static_cast<std::int64_t>(whole);
  part_ns_ -= whole;

  // The variance at the end of a line through `age` points, or of a fading memory; the mean absolute deviation is 0.8
  // to 0.87 standard deviations for any shape in question.
  const double sigma_ns = 1.25 * spread_ * period_ns_;
  double half_ns = std::numbers::sqrt3 * sigma_ns * std::sqrt(std::max(4.0 / age_, 1.25 / memory_));
  if (doubt_ > 0.0) half_ns += std::exchange(doubt_, 0.0) * period_ns_;
  std::int64_t t_ns = whole_ns_ + (part_ns_ >= 0.5 ? 1 : 0);
  if (t_ns <= last_given_ns_) {
    const std::int64_t forced_ns = last_given_ns_ + std::max<std::int64_t>(1, std::llround(period_ns_ / 16.0));
    half_ns += static_cast<double>(forced_ns - t_ns);
    t_ns = forced_ns;
  }
  last_given_ns_ = t_ns;
  reading.instant = {t_ns, static_cast<std::uint32_t>(std::min(half_ns, 4e9)), std::exchange(after_loss_, false)};
}

void DeviceClock::acquire(std::int64_t arrival_ns) noexcept {
  if (pause_ > 0) {
    --pause_;
    return;
  }
  stretch_[stretch_count_++] = arrival_ns;
  if (stretch_count_ != kShortStretch && stretch_count_ != kLongestStretch) return;
  // Not amid those that a stall held up: their stamps stand, and lie beyond what the clock would go on with.
  const std::size_t n = stretch_count_;
  if (4 * (stretch_[n - 1] - stretch_[n - 2]) * static_cast<std::int64_t>(n) < stretch_[n - 1] - stretch_[0]) {
    if (n == kLongestStretch) std::copy(stretch_.begin() + 1, stretch_.begin() + (stretch_count_--), stretch_.begin());
    return;
  }
  // Several streams of a device may share a stated rate that is not theirs.
  const double mean_ns =
      static_cast<double>(stretch_[stretch_count_ - 1] - stretch_[0]) / static_cast<double>(stretch_count_ - 1);
  if (mean_ns < 0.9 * nominal_ns_ || mean_ns > 1.5 * nominal_ns_) nominal_ns_ = 0.0;
  if (const auto grid = find_grid({stretch_.data(), stretch_count_}, nominal_ns_)) {
    lock(*grid, stretch_count_);
  } else if (stretch_count_ == kLongestStretch) {
    nominal_ns_ = 0.0;  // it did not help
    stretch_count_ = 0;
    pause_ = next_pause_;
    next_pause_ = std::min(2 * next_pause_, kLongestPause);
  }
}

void DeviceClock::lock(const ArrivalGrid& grid, std::size_t count) noexcept {
  locked_ = true;
  whole_ns_ = stretch_[0];
  part_ns_ = grid.last_ns;
  period_ns_ = grid.period_ns;
  memory_ = std::max(32.0, kMemory_s * kNsPerS / period_ns_);
  age_ = static_cast<double>(count);
  spread_ = std::max(grid.spread, kLeastSpread);
  shape_ = grid.shape;
  previous_arrival_ns_ = last_arrival_ns_;
  variance_ = 1.5 * spread_ * spread_;
  lost_part_ = grid.lost;
  too_early_ = doubt_ = mistrusted_ = 0.0;
  after_loss_ = false;
  next_pause_ = kFirstPause;
}

// What is held stands as it arrived; the clock is sought anew.
void DeviceClock::unlock() noexcept {
  for (; decided_ < count_; ++decided_) held(decided_).instant = {held(decided_).arrival_ns, 0, false};
  mistrusted_ = 0.0;
  locked_ = false;
  ++relocked_;
  stretch_count_ = 0;
  pause_ = 0;
}

}  // namespace dwell
