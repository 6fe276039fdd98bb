#include <algorithm>
#include <cmath>

#include "core/dwell/pipeline.hpp"
#include "tests/study/outcome.hpp"
#include "tests/study/recording.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {
namespace {

// Until it measures: a rig of a long memory needs several of its time constants, however it begins.
double patience_s(const Case& about) { return 100 * about.period_s() + 12 * about.motion->time_constant_s(); }

}  // namespace

StepOutcome play_step(const Case& about, const Trace& trace) {
  StepOutcome outcome;
  outcome.index = about.index;
  outcome.limit_periods = about.limit_periods;
  const State awaited = about.population == Population::stop ? State::idle : State::settling;
  Pipeline pipeline(about.rig);
  Player player(about);
  const double period_s = about.period_s();
  double since_s = NAN, step_s = INFINITY, told_s = 0.0;
  for (;;) {
    const bool completed = (pipeline.push(player.next()) & kCompleted) != 0;
    const double t_s = player.now_s();
    if (t_s < step_s) {
      const bool measuring = pipeline.state() == State::measuring;
      if (!measuring) {
        if (trace && std::isfinite(since_s))
          trace(text("measuring from %.2f periods on, left at %.2f", since_s / period_s, t_s / period_s));
        outcome.disturbed = outcome.disturbed || std::isfinite(since_s);
        since_s = NAN;
        if (trace && t_s > told_s) {
          trace(text("%8.2f periods: ", t_s / period_s) + pipeline.current().settling_reason);
          told_s = t_s + period_s;
        }
        if (t_s > patience_s(about) || std::isfinite(step_s)) return outcome;
      } else if (std::isnan(since_s)) {
        since_s = t_s;
      } else if (t_s > since_s + about.hold_periods * period_s && !std::isfinite(step_s)) {
        // At a whole period, where the table passes through its mean and does not jump.
        step_s = period_s * std::ceil(t_s / period_s + 0.5);
        about.motion->drive(step_s, about.after);
        if (trace) trace(text("measuring since %.2f, step at %.2f periods", since_s / period_s, step_s / period_s));
      }
      continue;
    }
    outcome.measured = true;
    const double after = (t_s - step_s) / period_s;
    if (trace) trace(text("%6.3f periods after the step: ", after) + to_string(pipeline.state()));
    const bool seen =
        awaited == State::idle ? pipeline.state() == State::idle : completed || pipeline.state() != State::measuring;
    if (seen) {
      // Records are the only clock: what is due is said at the first sample after.
      outcome.seen_periods = after - 1 / about.samples_per_period(0);
      return outcome;
    }
    if (after > 5 * about.limit_periods) return outcome;
  }
}

HoursOutcome play_hours(const Case& about, const Trace& trace) {
  HoursOutcome outcome;
  outcome.index = about.index;
  Pipeline pipeline(about.rig);
  Player player(about);
  double since_s = NAN;
  for (;;) {
    pipeline.push(player.next());
    const double t_s = player.now_s();
    const bool measuring = pipeline.state() == State::measuring;
    const bool over = t_s > 3600 * about.hours;
    if (std::isnan(since_s)) {
      if (measuring) since_s = t_s;
    } else if (!measuring || over) {
      outcome.hours += (t_s - since_s) / 3600;
      outcome.rearmed += !measuring;
      since_s = NAN;
      if (trace && !measuring)
        trace(text("at %.2f s, %.1f periods: ", t_s, t_s * about.frequency_hz) + to_string(pipeline.state()) + ", " +
              pipeline.current().settling_reason);
    }
    if (over) return outcome;
  }
}

RampsOutcome play_ramps(const Case& about, const Trace& trace) {
  RampsOutcome outcome;
  outcome.index = about.index;
  const Ramps& ramps = about.ramps;
  // So near its ends a ramp differs from the hold by less than the tolerance.
  const double rise_s = about.rig.tolerance * (ramps.hold_s - ramps.rise_s);
  const double fall_s = about.rig.tolerance * (ramps.end_s - ramps.fall_s);
  Pipeline pipeline(about.rig);
  Player player(about);
  double origin_s = NAN;
  const auto judge = [&] {
    const Dwell& dwell = pipeline.completed();
    const double from = dwell.settled_s + origin_s, to = dwell.end_s + origin_s, period = about.period_s();
    if (trace)
      trace(text("dwell from %.3f to %.3f, hold from %.3f to %.3f periods, ended by ", from / period, to / period,
                 ramps.hold_s / period, ramps.fall_s / period) +
            to_string(dwell.ended_by) + "; " + dwell.settling_reason);
    if (!std::isfinite(dwell.settled_s)) return;
    const bool within = from >= ramps.hold_s - rise_s && to <= ramps.fall_s + fall_s;
    outcome.found = outcome.found || within;
    outcome.beyond = outcome.beyond || !within;
  };
  double told_s = 0.0;
  do {
    const Record record = player.next();
    if (std::isnan(origin_s)) origin_s = 1e-9 * static_cast<double>(record.t_ns);
    if (pipeline.push(record) & kCompleted) judge();
    if (trace && player.now_s() > told_s) {
      trace(text("%6.2f periods: ", player.now_s() / about.period_s()) + to_string(pipeline.state()) + ", " +
            pipeline.current().settling_reason);
      told_s = player.now_s() + 0.25 * about.period_s();
    }
  } while (player.now_s() < ramps.end_s + 3 * about.period_s());
  if (pipeline.finish() & kCompleted) judge();
  return outcome;
}

}  // namespace dwell::study
