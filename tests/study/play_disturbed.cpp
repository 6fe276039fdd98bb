#include <algorithm>
#include <cmath>
#include <optional>

#include "core/dwell/pipeline.hpp"
#include "tests/study/disturbed.hpp"
#include "tests/study/motion_witness.hpp"
#include "tests/study/recording.hpp"
#include "tests/study/service_witness.hpp"

namespace dwell::study {
namespace {

constexpr double kPatience = 1.5;     // times the lateness that one dwell in twenty may have
constexpr double kSeenWithin = 50.0;  // periods, that the drive has changed

double oracle_s(const Case& about) {
  double last_s = about.change_s;
  for (int c = 0; c < about.channels(); ++c) last_s = std::max(last_s, about.motion->last_above(c, about.threshold(c)));
  return last_s;
}

double largest(const std::vector<double>& values, const std::vector<bool>& of) {
  double most = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (of[i]) most = std::max(most, std::abs(values[i]));
  return most;
}

// Errors over their stated standard uncertainties, of all that a dwell shows.
double worst_of(const Chain& truth, const Dwell& dwell) {
  double worst = 0.0;
  for (std::size_t e = 0; e < dwell.elements.size(); ++e) {
    const ElementEstimate& given = dwell.elements[e];
    if (!given.identifiable) continue;
    const double c = std::abs(given.stiffness.value - truth.stiffness[e]) / given.stiffness.u;
    const double r = std::abs(given.damping.value - truth.damping[e]) / given.damping.u;
    // Not a number: as bad as any.
    if (!(c <= worst)) worst = std::isnan(c) ? INFINITY : c;
    if (!(r <= worst)) worst = std::isnan(r) ? INFINITY : r;
  }
  return worst;
}

// What a dwell before the transient shows when only the model is wrong. It cannot know better, so it is judged against
// this; what devices add it must report. An element that it withholds is judged against the truth. None: there is no
// such dwell.
std::optional<Chain> shown_before_the_transient(const Case& about) {
  Case alone = about;
  alone.mishaps.clear();
  Pipeline pipeline(alone.rig);
  Player player(alone);
  while (player.now_s() < about.change_s + kSeenWithin * about.period_s()) {
    if (!(pipeline.push(player.next()) & kCompleted) || !(pipeline.completed().settled_s < about.change_s)) continue;
    Chain shown = about.chain;
    for (std::size_t e = 0; e < shown.stiffness.size(); ++e) {
      const ElementEstimate& element = pipeline.completed().elements[e];
      if (!element.identifiable) continue;
      shown.stiffness[e] = element.stiffness.value;
      shown.damping[e] = element.damping.value;
    }
    return shown;
  }
  return std::nullopt;
}

void tell(const Case& about, const Dwell& dwell, double worst, bool warned, const Trace& trace) {
  trace(text("dwell from %.2f to %.2f periods, ended by %s: largest error %.3g u, %s",
             dwell.settled_s / about.period_s(), dwell.end_s / about.period_s(), to_string(dwell.ended_by), worst,
             warned ? "the cause is named" : "the cause is not named"));
  for (std::size_t e = 0; e < dwell.elements.size(); ++e) {
    const ElementEstimate& given = dwell.elements[e];
    if (!given.identifiable) {
      trace(text("  element %zu withheld: ", e + 1) + given.reason);
      continue;
    }
    trace(text("  element %zu: c off by %.3g %% (%.3g u), r off by %.3g %% (%.3g u)", e + 1,
               100 * (given.stiffness.value / about.chain.stiffness[e] - 1),
               (given.stiffness.value - about.chain.stiffness[e]) / given.stiffness.u,
               100 * (given.damping.value / about.chain.damping[e] - 1),
               (given.damping.value - about.chain.damping[e]) / given.damping.u));
    for (const BudgetShare& share : given.budget)
      if (share.stiffness_share > 0.1 || share.damping_share > 0.1)
        trace("    " + share.source + text(": %.2f of c, %.2f of r", share.stiffness_share, share.damping_share));
  }
  for (const Warning& warning : dwell.warnings) trace("  warning: " + warning.what);
  for (const Doubt& doubt : dwell.doubts) trace("  doubt: " + doubt.what);
}

void judge(const Case& about, const Dwell& dwell, const Moved& moved, DisturbedOutcome& outcome, const Trace& trace) {
  if (!std::isfinite(dwell.settled_s)) {
    if (trace) trace(text("no result up to %.2f periods: ", dwell.end_s / about.period_s()) + dwell.settling_reason);
    return;
  }
  bool warned = false;
  for (const std::string& line : told_by(dwell))
    for (const Disturbance& disturbance : about.disturbances) warned = warned || names(about, disturbance, line);
  const double worst = worst_of(about.chain, dwell);
  outcome.settled = true;
  outcome.warned = outcome.warned || warned;
  outcome.worst = std::max(outcome.worst, worst);
  double silent = warned ? 0.0 : worst;
  if (silent > kWrong && moved.by_transient && dwell.settled_s < about.change_s)
    if (const auto shown = shown_before_the_transient(about)) silent = worst_of(*shown, dwell);
  if (silent > outcome.worst_silent) {
    outcome.worst_silent = silent;
    outcome.doubted = !dwell.doubts.empty();
  }
  bool all = !dwell.elements.empty();
  for (std::size_t e = 0; e < dwell.elements.size(); ++e)
    all = all && (dwell.elements[e].identifiable || !moved.stands_out[e]);
  outcome.reported = outcome.reported || all;
  outcome.trusted = outcome.trusted || (all && dwell.doubts.empty());
  if (trace) tell(about, dwell, worst, warned, trace);
}

void hear_service(const Case& about, double until_s, DisturbedOutcome& outcome, const Trace& trace) {
  for (const std::string& line : objections_of_service(about, until_s)) {
    if (trace) trace("service: " + line);
    for (const Disturbance& disturbance : about.disturbances)
      outcome.told_live = outcome.told_live || names(about, disturbance, line);
  }
}

void hear_motion(const Case& about, double until_s, DisturbedOutcome& outcome, const Trace& trace) {
  const std::vector<std::string> lines = objections_of_motion(about, until_s);
  if (trace && lines.empty()) trace("any motion: no objection");
  for (const std::string& line : lines) {
    if (trace) trace("any motion: " + line);
    for (const Disturbance& disturbance : about.disturbances)
      outcome.told_beside = outcome.told_beside || names(about, disturbance, line);
  }
}

}  // namespace

DisturbedOutcome play_disturbed(const Case& about, const Trace& trace) {
  DisturbedOutcome outcome;
  outcome.index = about.index;
  for (const Disturbance& disturbance : about.disturbances) outcome.kinds.push_back(disturbance.kind);
  const double oracle = oracle_s(about), seconds = about.hold_periods * about.period_s();
  const double end_s = oracle + kPatience * std::max(10 * about.period_s(), about.motion->time_constant_s()) + seconds;
  const Moved moved = moved_by(about, oracle, seconds);
  outcome.counts = moved.shows >= kShows;
  outcome.covered = moved.surely < kShows;
  outcome.harmless = moved.harmless();
  outcome.moved = std::max(largest(moved.c, moved.stands_out), largest(moved.r, moved.stands_out));
  if (trace) {
    trace(
        text("settled in truth at %.2f periods, played to %.2f", oracle / about.period_s(), end_s / about.period_s()));
    for (const Complex& pole : about.motion->natural())
      trace(text("true pole %.5g %.5g 1/s", pole.real(), pole.imag()));
    for (std::size_t e = 0; e < moved.c.size(); ++e)
      trace(text("a plain fit of element %zu is moved by %.3g u in c, %.3g u in r%s", e + 1, moved.c[e], moved.r[e],
                 moved.stands_out[e] ? "" : " (too weak to be reported)"));
    if (std::isfinite(moved.shows))
      trace(text("the fault of the model shows by %.3g; beside the uncertainty of what is identified by %.3g",
                 moved.shows, moved.surely));
  }
  Pipeline pipeline(about.rig);
  Player player(about);
  double told_s = 0.0;
  do {
    if (pipeline.push(player.next()) & kCompleted) judge(about, pipeline.completed(), moved, outcome, trace);
    if (trace && player.now_s() > told_s) {
      trace(text("%8.2f periods: ", player.now_s() / about.period_s()) + to_string(pipeline.state()) + ", " +
            pipeline.current().settling_reason);
      told_s = player.now_s() + 5 * about.period_s();
    }
  } while (player.now_s() < end_s);
  if (pipeline.finish() & kCompleted) judge(about, pipeline.completed(), moved, outcome, trace);
  if (trace || outcome.silent()) {
    hear_motion(about, end_s, outcome, trace);
    hear_service(about, end_s, outcome, trace);
  }
  if (trace)
    trace(outcome.silent_throughout() ? text("WRONG WITHOUT A WORD: %.3g u", outcome.worst_silent)
          : outcome.silent()       ? text("wrong by %.3g u, and said by the method of any motion", outcome.worst_silent)
          : outcome.worst > kWrong ? (outcome.counts ? "wrong, and said" : "wrong, but nothing could tell")
          : !outcome.settled       ? "no result"
          : !outcome.reported      ? "withheld in part"
                                   : "right");
  return outcome;
}

}  // namespace dwell::study
