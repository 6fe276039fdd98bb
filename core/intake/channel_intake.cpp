#include "core/intake/channel_intake.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/wording.hpp"

namespace dwell {
namespace {

// What converters and gateways send at the end of a type's range, or for "no value".
constexpr double kEndCodes[] = {32767.0,      -32768.0,      65535.0,      32768.0,
                                2147483647.0, -2147483648.0, 4294967295.0, 2147483648.0};
// A reading's noise is told from the rounding of double precision: relative to the largest reading.
constexpr double kRealNoise = 1e-9;
// Identical readings in a row that no motion explains whose mean difference is kMoves rounding steps: at a crest, where
// it is slowest, √(readings a period) / 5 of such a motion round to one number; noise makes them fewer.
constexpr double kMoves = 20.0, kAtCrest = 0.25;
constexpr std::int64_t kAnyway = 3;
// Fewest readings a period, at which a motion of three harmonics does not turn from one reading to the next.
constexpr double kTurnsSlowly = 12.0;
// Readings by which an older one again lags: two or three polls.
constexpr double kOlderLags = 2.5;

// The gate now and then leaves out good readings while a transient is large. It says nothing of up to kUnsaid √N of N
// readings. If all lie 8 σ off on one side, k of them move a phasor by 16 k σ/N. With u = σ √(2/N) that is 0.57 u at
// this limit. Chosen on 400 healthy dwells of the study: none blames a channel. Other values were not tried.
constexpr double kUnsaid = 0.05;

}  // namespace

ChannelIntake::ChannelIntake(const Channel& channel)
    : gain_(channel.si_per_unit * channel.scale),
      offset_(channel.si_per_unit * channel.offset),
      low_(channel.range_low.value_or(-INFINITY) * channel.si_per_unit),
      high_(channel.range_high.value_or(INFINITY) * channel.si_per_unit),
      si_per_unit_(channel.si_per_unit),
      unit_(unit_text(channel.unit)),
      judged_(channel.measures != Quantity::auxiliary) {}

ChannelIntake::Says ChannelIntake::judge(Reading& reading, double omega) noexcept {
  const double raw = reading.value, before = newest_;
  ++readings_;
  if (first_ns_ == INT64_MIN) first_ns_ = reading.t_ns;
  newest_ns_ = reading.t_ns;
  if (raw != newest_) changed_ns_ = reading.t_ns;
  newest_ = raw;
  const bool code = judged_ && end_code(raw);
  overrange_now_ = code || si(raw) < low_ || si(raw) > high_;
  if (overrange_now_) {
    ++left_;
    ++overrange_;
    if (code) ++end_codes_;
    return Says::leave;
  }
  largest_ = std::max(largest_, raw);
  smallest_ = std::min(smallest_, raw);
  if (!judged_) return Says::take;

  if (const double interval = interval_s(); interval > 0) readings_a_period_ = kTwoPi / (omega * interval);
  const bool same = held_.add(raw, rounding_.step());
  cluster_.add(raw, before);
  pile_up_.add(raw, before, held_.mean_difference());
  const bool spike = spikes_.spike(raw);
  if (spike && !motion_.active()) {
    ++left_;
    ++spiked_;
    return Says::leave;
  }
  const std::int64_t read_ns = reading.t_ns;
  // Of a held register the value taken last may come back after a foreign reading.
  const bool was_stuck = std::exchange(stuck_, !held_.held() && same && frozen(omega));
  if (stuck_ && !was_stuck) pile_up_.stuck();
  if (stuck_ || (held_.held() && (same || raw == newest_taken_))) {
    ++left_;
    ++repeated_;
    old_seen_ns_ = read_ns;
    return Says::leave;
  }
  const RefreshClock refresh = same ? refresh_ : date_refresh(reading);
  const Says says = motion_.judge(reading, omega, apart());
  if (says != Says::leave) dated_ns_ = reading.t_ns;
  far_spike_ = far_spike_ || (spike && (says == Says::leave || says == Says::wait));
  if (says == Says::take || says == Says::give_back) {
    for (const Reading& back : motion_.waiting()) {
      rounding_.add(back.value - newest_taken_);
      newest_taken_ = back.value;
    }
    rounding_.add(raw - newest_taken_);
    newest_taken_ = raw;
    refresh_ = refresh;
    old_seen_ns_ = read_ns;
    if (held_.held()) refresh_half_ns_ += reading.refresh_half_ns, refreshes_ += 1;
  }
  return says;
}

// Puts the reading's instant right where the register is held; what is then known of its clock.
RefreshClock ChannelIntake::date_refresh(Reading& reading) const noexcept {
  RefreshClock refresh = refresh_;
  if (!(held_.held() || held_.suspected()) || old_seen_ns_ == INT64_MIN) return refresh;
  const RefreshClock::Instant instant = refresh.refreshed(old_seen_ns_, reading.t_ns);
  if (!held_.held()) return refresh;
  reading.t_ns = std::max(instant.t_ns, dated_ns_ + 1);
  reading.refresh_half_ns = instant.half_ns;
  return refresh;
}

double ChannelIntake::refresh_half_s() const noexcept {
  return held_.held() && refreshes_ > 0 ? 1e-9 * refresh_half_ns_ / refreshes_ : 0.0;
}

// An end of an integer type, and nothing has been seen beyond it.
bool ChannelIntake::end_code(double raw) const noexcept {
  if (std::find(std::begin(kEndCodes), std::end(kEndCodes), raw) == std::end(kEndCodes)) return false;
  return raw > largest_ || raw < smallest_;
}

bool ChannelIntake::frozen(double omega) const noexcept {
  const double interval = interval_s();
  if (!(interval > 0) || !(held_.mean_difference() > kMoves * apart())) return false;
  return static_cast<double>(held_.run() - kAnyway) > kAtCrest * std::sqrt(kTwoPi / (omega * interval));
}

void ChannelIntake::begin_hold() noexcept {
  pile_up_.restart(noise());
  held_.restart();
  cluster_.restart();
  motion_.restart();
  refresh_half_ns_ = refreshes_ = 0.0;
  residuals2_ = INFINITY;
  held_at_begin_ = held_.held();
  first_ns_ = INT64_MIN;
  readings_ = overrange_ = end_codes_ = spiked_ = repeated_ = 0;
  begin_to_count();
}

void ChannelIntake::begin_to_count() noexcept {
  before_counting_ = {readings_, spiked_, motion_.foreign().all + repeated_};
  far_spike_ = false;
}

bool ChannelIntake::left_out_matters() const noexcept {
  if (overrange_ > 0 || spiked_ > before_counting_.spiked || far_spike_) return true;
  const std::uint64_t left = motion_.foreign().all + (held() ? 0 : repeated_);
  return static_cast<double>(left) - static_cast<double>(before_counting_.left) >
         kUnsaid * std::sqrt(static_cast<double>(readings_ - before_counting_.readings));
}

// Smallest distance of two readings that differ. Readings that were rounded twice have the coarser step.
double ChannelIntake::apart() const noexcept {
  const double step = rounding_.step(), seen = held_.step();
  return std::isfinite(seen) ? std::max(step, seen) : step;
}

double ChannelIntake::same_for_s() const noexcept {
  return changed_ns_ == INT64_MIN ? 0.0 : 1e-9 * static_cast<double>(newest_ns_ - changed_ns_);
}

double ChannelIntake::interval_s() const noexcept {
  return readings_ > 1 ? 1e-9 * static_cast<double>(newest_ns_ - first_ns_) / static_cast<double>(readings_ - 1) : 0.0;
}

void ChannelIntake::see_residuals(double sigma) noexcept {
  const double raw = sigma / std::abs(gain_);
  if (!std::isfinite(raw)) return;
  residuals2_ = std::isfinite(residuals2_) ? residuals2_ + (raw * raw - residuals2_) / 8 : raw * raw;
}

PileUp::Noise ChannelIntake::noise() const noexcept {
  const double noise = std::min(motion_.noise(), std::sqrt(residuals2_)),
               largest = std::max(std::abs(largest_), std::abs(smallest_));
  return {noise > kRealNoise * largest ? noise : 0.0, apart()};
}

double ChannelIntake::clipping_bias() const noexcept {
  if (pile_up_.seen() == 0) return 0.0;
  double bias = 0.0;
  for (const std::int64_t clipped : {clipped_above(), clipped_below()}) {
    const double part = static_cast<double>(clipped) / static_cast<double>(pile_up_.seen());
    bias += 2 / (3 * std::numbers::pi) * std::pow(std::numbers::pi * part, 3);
  }
  return bias;
}

HeldReadings::Again ChannelIntake::again() const noexcept {
  if (held() || readings_a_period_ < kTurnsSlowly || readings_ == 0) return {};
  return held_.again(static_cast<double>(motion_.foreign().repeats + repeated_) / static_cast<double>(readings_));
}

double ChannelIntake::repeat_bias() const noexcept {
  const HeldReadings::Again again = this->again();
  if (again.one_before == 0 && again.older == 0) return 0.0;
  return (again.one_before + kOlderLags * again.older) * kTwoPi / readings_a_period_;
}

double ChannelIntake::left_out() const noexcept {
  const std::uint64_t bad = overrange_ + spiked_ + motion_.foreign().all;
  return readings_ == 0 ? 0.0 : static_cast<double>(bad) / static_cast<double>(readings_);
}

Condition ChannelIntake::condition() const noexcept {
  if (newest_ns_ == INT64_MIN) return Condition::unheard;
  if (clipped()) return Condition::clipped;
  if (held()) return Condition::held;
  if (overrange_now_) return Condition::overrange;
  return left_out_matters() || clustered() || repeat_bias() > 0 ? Condition::gated : Condition::ok;
}

std::string ChannelIntake::in_unit(double raw) const { return brief(si(raw) / si_per_unit_, 6) + " " + unit_; }

std::string ChannelIntake::held_reason() const {
  return "refreshed every " + brief(1e3 * interval_s() * held_.reads_each()) + " ms, polled every " +
         brief(1e3 * interval_s()) + " ms";
}

std::string ChannelIntake::clipped_reason() const {
  std::string text = "clipped:";
  const auto end = [&](std::int64_t clipped, double at) {
    if (clipped == 0) return;
    text += (text.back() == ':' ? " " : " and ") +
            percent(static_cast<double>(clipped) / static_cast<double>(pile_up_.seen())) +
            " of its readings are exactly " + in_unit(at);
  };
  end(clipped_above(), pile_up_.largest());
  end(clipped_below(), pile_up_.smallest());
  return text;
}

std::string ChannelIntake::clustered_reason() const {
  return "a cluster of readings: " + percent(cluster_.part()) + " of them are exactly " + in_unit(cluster_.value());
}

std::string ChannelIntake::repeat_reason() const {
  const HeldReadings::Again again = this->again();
  return "about " + percent(again.one_before + again.older) + " of its readings repeat an older one";
}

std::string ChannelIntake::left_out_reason() const {
  if (!left_out_matters()) return "";
  const MotionGate::Foreign& foreign = motion_.foreign();
  std::string text;
  const auto add = [&](std::uint64_t count, const char* one, const char* many) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + (count == 1 ? one : many);
  };
  add(overrange_ - end_codes_, " reading beyond its range", " readings beyond its range");
  add(end_codes_, " end code of an integer type", " end codes of an integer type");
  add(foreign.repeats + (held() ? 0 : repeated_), " repeat of an older reading", " repeats of an older reading");
  const std::uint64_t far = spiked_ + foreign.all - foreign.repeats;
  add(far, " reading far from all others", " readings far from all others");
  if (far > 1 && foreign.commonest > 1) text += " (with a cluster at " + in_unit(foreign.value) + ")";
  return text.empty() ? text : "left out of " + std::to_string(readings_) + " readings: " + text;
}

std::string ChannelIntake::condition_reason() const {
  switch (condition()) {
    case Condition::clipped:
      return clipped_reason();
    case Condition::held:
      return held_reason();
    case Condition::overrange:
    case Condition::gated:
      if (clustered()) return clustered_reason();
      return repeat_bias() > 0 ? repeat_reason() : left_out_reason();
    default:
      return "";
  }
}

}  // namespace dwell
