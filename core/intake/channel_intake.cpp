#include "core/intake/channel_intake.hpp"

#include <algorithm>
#include <numbers>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/rounding.hpp"
#include "core/base/wording.hpp"

namespace dwell {
namespace {

// A run of identical readings longer than any motion explains. A sine whose mean difference is kMoves rounding steps
// has √(readings a period) / 5 identical readings at its crest, where it is slowest; with noise fewer. kAtCrest is that
// factor with a margin.
constexpr double kMoves = 20.0, kAtCrest = 0.25;
constexpr std::int64_t kAnyway = 3;
// Fewest readings a period at which a motion of three harmonics does not turn within one reading.
constexpr double kTurnsSlowly = 12.0;
// Largest part of the amplitude that clipping may cost unseen, without a warning: the default accuracy that is asked of
// a model. Rounding in steps of 2.4 % of the amplitude can hide so much.
constexpr double kMostUnseen = 0.05;
// Age of an older reading that is repeated, in readings: it is two or three polls old.
constexpr double kOlderLags = 2.5;

}  // namespace

ChannelIntake::ChannelIntake(const Channel& channel)
    : numbers_(channel), judged_(channel.measures != Quantity::auxiliary) {}

ChannelIntake::Says ChannelIntake::judge(Reading& reading, double omega) noexcept {
  const double raw = reading.value, before = times_.add(reading.t_ns, raw);
  overrange_now_ = false;
  if (!codes_.amid(raw)) {
    const bool code = judged_ && codes_.has(raw);
    overrange_now_ = code || numbers_.beyond_range(raw);
    if (overrange_now_) {
      left_.beyond_range(code);
      return Says::leave;
    }
    codes_.see(raw);
  }
  if (!judged_) return Says::take;

  if (const auto interval = times_.mean_interval(); interval.span_ns > 0) sampled_ = {omega, interval};
  const bool same = held_.add(raw, rounding_.step());
  cluster_.add(raw, before);
  pile_up_.add(
      raw, before, [this] { return held_.mean_difference(); }, [this] { return noise(); });
  const bool spike = spikes_.spike(raw);
  if (spike && !motion_.active()) {
    left_.spike();
    return Says::leave;
  }
  const std::int64_t read_ns = reading.t_ns;
  const bool was_stuck = std::exchange(stuck_, !held() && same && frozen());
  if (stuck_ && !was_stuck) pile_up_.stuck();
  // Of a held register the value taken last may come back after a foreign reading.
  if (stuck_ || (same && held_.repeats_tell_nothing()) || (held() && raw == newest_taken_)) {
    left_.repeat();
    stamps_.see_old(read_ns);
    return Says::leave;
  }
  stamps_.next();
  if (!same && (held() || held_.suspected())) stamps_.date(reading, held());
  const Says says = motion_.judge(reading, omega, apart());
  if (says != Says::leave) stamps_.keep_order(reading.t_ns);
  if (spike && (says == Says::leave || says == Says::wait)) left_.far_spike();
  return count(reading, read_ns, says);
}

void ChannelIntake::begin(PlainRun& run, double omega) const noexcept {
  run.close();
  if (!judged_ || times_.count() < 2 || !held_.plain()) return;
  held_.copy_to(run.before());
  const std::span<const double, PlainRun::kBefore> before = run.before();
  if (times_.newest() == before.back() && cluster_.remembers(before.last<8>()) && motion_.plain(before, omega))
    run.begin(motion_.newest_ns(), motion_.gap_ns());
}

std::size_t ChannelIntake::plain_ones(const PlainRun& run) const noexcept {
  const SpikeGate::Bounds bounds = spikes_.bounds();
  if (std::isnan(bounds.low)) return 0;
  const double low = std::max({codes_.lowest(), pile_up_.amid_above(), bounds.low}),
               high = std::min({codes_.highest(), pile_up_.amid_below(), bounds.high}), least = held_.step();
  const double candidate = cluster_.value(), foreign = motion_.foreign().cluster() ? motion_.foreign().value() : NAN;
  std::size_t plain = 0;
  double before = run.at(-1);
  for (const double number : run.readings()) {
    if (!(number > low && number < high) || number == candidate || number == foreign ||
        !(std::abs(number - before) >= least) || run.recurs(plain))
      break;
    before = number;
    ++plain;
  }
  return plain;
}

void ChannelIntake::take_plain(PlainRun& run, double omega) noexcept {
  run.shorten(plain_ones(run));
  motion_.take_plain(
      run, [this] { return apart(); },
      [this](double number) {
        rounding_.add(number - newest_taken_);
        newest_taken_ = number;
        held_.add_plain(number);
      });
  const std::size_t taken = run.count();
  if (taken == 0) return;
  PlainRun::Range range = run.range_but_last();
  PlainRun::Range left = range;  // of the numbers that were left for the next one
  left.see(run.at(-1));
  range.see(run.last());
  times_.add_different(taken, run.last_ns(), run.last());
  overrange_now_ = stuck_ = false;
  sampled_ = {omega, times_.mean_interval()};
  held_.end_plain(run.before(taken - 1, taken), left.low, left.high);
  cluster_.add_new(run.readings(), range.low, range.high);
  pile_up_.add_amid(taken);
  spikes_.add_good(taken, range.low, range.high);
  stamps_.take_plain(run.last_ns());
}

// Notes the gate's answer for the reading, which was read at read_ns.
ChannelIntake::Says ChannelIntake::count(const Reading& reading, std::int64_t read_ns, Says says) noexcept {
  if (says != Says::take && says != Says::give_back) return says;
  const auto take = [&](double value) {
    rounding_.add(value - newest_taken_);
    newest_taken_ = value;
  };
  for (const Reading& back : motion_.waiting()) take(back.value);
  take(reading.value);
  stamps_.take(held() ? static_cast<double>(reading.refresh_half_ns) : -1.0);
  stamps_.see_old(read_ns);
  return says;
}

bool ChannelIntake::frozen() const noexcept {
  const double readings = readings_a_period();
  if (!(readings > 0) || !(held_.mean_difference() > kMoves * apart())) return false;
  return static_cast<double>(held_.run() - kAnyway) > kAtCrest * std::sqrt(readings);
}

double ChannelIntake::readings_a_period() const noexcept {
  return sampled_.interval.span_ns > 0 ? kTwoPi / (sampled_.omega * sampled_.interval.s()) : 0.0;
}

void ChannelIntake::begin_hold() noexcept {
  pile_up_.restart(noise());
  held_.restart();
  cluster_.restart();
  motion_.restart();
  stamps_.restart();
  times_.restart();
  left_.begin_hold();
  residuals2_ = INFINITY;
  held_at_begin_ = held();
  begin_to_count();
}

void ChannelIntake::begin_to_count() noexcept { left_.begin_to_count(times_.count(), motion_.foreign().all()); }

bool ChannelIntake::left_out_matters() const noexcept {
  return left_.matters(times_.count(), motion_.foreign().all(), held());
}

// The smallest distance of two different readings. Readings that were rounded twice have the coarser step.
double ChannelIntake::apart() const noexcept {
  const double step = rounding_.step(), seen = held_.step();
  return std::isfinite(seen) ? std::max(step, seen) : step;
}

void ChannelIntake::see_residuals(double sigma) noexcept {
  const double raw = numbers_.difference_of_si(sigma);
  if (!std::isfinite(raw)) return;
  residuals2_ = std::isfinite(residuals2_) ? residuals2_ + (raw * raw - residuals2_) / 8 : raw * raw;
}

PileUp::Noise ChannelIntake::noise() const noexcept {
  const double noise = std::min(motion_.noise(), std::sqrt(residuals2_));
  return {noise > kOnlyRounding * codes_.largest() ? noise : 0.0, apart()};
}

double ChannelIntake::clipping_bias() const noexcept { return pile_up_.loss(noise()); }

HeldReadings::Again ChannelIntake::again() const noexcept {
  if (held() || readings_a_period() < kTurnsSlowly || times_.count() == 0) return {};
  return held_.again(static_cast<double>(motion_.foreign().repeats() + left_.repeats()) /
                     static_cast<double>(times_.count()));
}

double ChannelIntake::repeat_bias() const noexcept {
  const HeldReadings::Again again = this->again();
  if (again.one_before == 0 && again.older == 0) return 0.0;
  return (again.one_before + kOlderLags * again.older) * kTwoPi / readings_a_period();
}

double ChannelIntake::left_out() const noexcept {
  const std::uint64_t bad = left_.overrange() + left_.spikes() + motion_.foreign().all(), all = times_.count();
  return all == 0 ? 0.0 : static_cast<double>(bad) / static_cast<double>(all);
}

double ChannelIntake::late() const noexcept {
  const std::uint64_t all = times_.count();
  return all == 0 ? 0.0 : static_cast<double>(motion_.uncertain_in_hold()) / static_cast<double>(all);
}

Condition ChannelIntake::condition() const noexcept {
  if (!times_.heard()) return Condition::unheard;
  if (clipped()) return Condition::clipped;
  if (held()) return Condition::held;
  if (overrange_now_) return Condition::overrange;
  return left_out_matters() || clustered() || repeat_bias() > 0 ? Condition::gated : Condition::ok;
}

std::string ChannelIntake::held_reason() const {
  return "refreshed every " + brief(1e3 * times_.interval_s() * held_.reads_each()) + " ms, polled every " +
         brief(1e3 * times_.interval_s()) + " ms";
}

std::string ChannelIntake::clipped_reason() const {
  std::string text = "clipped:";
  const auto end = [&](std::int64_t clipped, double at) {
    if (clipped == 0) return;
    text += (text.back() == ':' ? " " : " and ") +
            percent(static_cast<double>(clipped) / static_cast<double>(pile_up_.seen())) +
            " of its readings are exactly " + numbers_.text(at);
  };
  end(clipped_above(), pile_up_.upper_end(noise()));
  end(clipped_below(), pile_up_.lower_end(noise()));
  return text;
}

std::string ChannelIntake::coarse_reason() const {
  const double step = rounding_.step();
  if (!std::isfinite(step) || !(pile_up_.unseen_loss(step) > kMostUnseen)) return "";
  return "its readings are rounded to steps of " + numbers_.text(step) +
         ": clipping by less than five steps is not found, and may cost up to " + percent(pile_up_.unseen_loss(step)) +
         " of the amplitude; choose a finer resolution or a smaller range";
}

std::string ChannelIntake::clustered_reason() const {
  return "a cluster of readings: " + percent(cluster_.part()) + " of them are exactly " +
         numbers_.text(cluster_.value());
}

std::string ChannelIntake::repeat_reason() const {
  const HeldReadings::Again again = this->again();
  return "about " + percent(again.one_before + again.older) + " of its readings repeat an older one";
}

std::string ChannelIntake::left_out_reason() const {
  if (!left_out_matters()) return "";
  const ForeignReadings& foreign = motion_.foreign();
  std::string text;
  const auto add = [&](std::uint64_t count, const char* one, const char* many) {
    if (count > 0) text += (text.empty() ? "" : ", ") + std::to_string(count) + (count == 1 ? one : many);
  };
  add(left_.overrange() - left_.codes(), " reading beyond its range", " readings beyond its range");
  add(left_.codes(), " end code of an integer type", " end codes of an integer type");
  const std::uint64_t repeats = foreign.repeats() + (held() ? 0 : left_.repeats());
  add(repeats, " repeat of an older reading", " repeats of an older reading");
  if (repeats > 1) text += " (" + percent(static_cast<double>(repeats) / static_cast<double>(times_.count())) + ")";
  const std::uint64_t far = left_.spikes() + foreign.all() - foreign.repeats();
  add(far, " reading far from all others", " readings far from all others");
  if (far > 1 && foreign.cluster()) text += " (with a cluster at " + numbers_.text(foreign.value()) + ")";
  return text.empty() ? text : "left out of " + std::to_string(times_.count()) + " readings: " + text;
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
