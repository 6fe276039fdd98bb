#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "core/dwell/pipeline.hpp"
#include "tests/study/bound.hpp"
#include "tests/study/cpu_time.hpp"
#include "tests/study/disturbed.hpp"
#include "tests/study/outcome.hpp"
#include "tests/study/recording.hpp"
#include "tests/study/script.hpp"

namespace dwell::study {
namespace {

constexpr double kGiveUp = 2.0;      // times the lateness that one dwell in twenty may have
constexpr double kOldVerdict = 2.0;  // periods after a change, within which a verdict may still be the old drive's

// The last instant at which any channel's transient is above its threshold.
double oracle_of(const Case& about) {
  double last_s = about.change_s;
  for (int c = 0; c < about.channels(); ++c) last_s = std::max(last_s, about.motion->last_above(c, about.threshold(c)));
  return last_s;
}

void judge_left(const Case& about, double verdict_s, Outcome& outcome) {
  for (int c = 0; c < about.channels(); ++c) {
    const double left = about.motion->largest_from(c, verdict_s) / about.threshold(c);
    if (left > outcome.left) outcome.left = left, outcome.left_channel = c;
  }
}

bool speaks_of_hum(const Dwell& dwell) {
  return std::any_of(dwell.warnings.begin(), dwell.warnings.end(),
                     [](const Warning& warning) { return warning.kind == WarningKind::hum; });
}

// Whether hum, as sampled, falls within 1/T of a harmonic that is fitted. Irregular instants spread an alias but for
// the part that is coherent; that of the hum itself stays whole.
bool hum_inseparable(const Case& about, double seconds) {
  for (const Line& line : about.lines) {
    if (line.hum == 0) continue;
    for (int h = 1; h <= about.rig.excitation.harmonics; ++h)
      for (const double side : {-1.0, 1.0}) {
        const double off = line.hum_hz + side * h * about.frequency_hz;
        if (std::abs(std::remainder(off, line.rate_hz)) < 1 / seconds) return true;
      }
  }
  return false;
}

void judge_elements(const Case& about, const Dwell& dwell, Outcome& outcome) {
  const double seconds = dwell.end_s - dwell.settled_s, omega = 2 * M_PI * about.frequency_hz;
  outcome.counted_periods = seconds * about.frequency_hz;
  outcome.hum_inseparable = hum_inseparable(about, seconds);
  outcome.hum_warned = speaks_of_hum(dwell);
  for (const Warning& warning : dwell.warnings)
    if (outcome.blamed.empty() && !blameless(warning) && blames(about, warning.what)) outcome.blamed = warning.what;
  for (const Doubt& doubt : dwell.doubts)
    if (doubt.by_chance)
      outcome.by_chance = true;
    else if (outcome.blamed.empty())
      outcome.blamed = doubt.what;
  outcome.answer_s = true_s(about, dwell.end_s) - about.change_s;
  const Script script = run_script(about);
  outcome.naive_answer_s = script.answer_s - about.change_s;
  const std::vector<ElementBound> bounds = bounds_of(about, seconds);
  for (std::size_t e = 0; e < dwell.elements.size(); ++e) {
    const ElementEstimate& given = dwell.elements[e];
    const ElementBound& bound = bounds[e];
    ElementOutcome element;
    element.reported = given.identifiable;
    element.snr_d = std::abs(bound.d) / bound.sigma_d;
    element.snr_Z = std::abs(bound.Z) / bound.sigma_Z;
    if (element.reported) {
      const double c = given.stiffness.value - about.chain.stiffness[e];
      const double r = given.damping.value - about.chain.damping[e];
      element.c_error = c / bound.sigma_Z;
      element.r_error = r * omega / bound.sigma_Z;
      element.c_U95 = c / given.stiffness.U95;
      element.r_U95 = r / given.damping.U95;
      element.c_relative = std::abs(c / about.chain.stiffness[e]);
      element.r_relative = std::abs(r / about.chain.damping[e]);
      element.naive_c = std::abs(script.Z[e].real() / about.chain.stiffness[e] - 1);
      element.naive_r = std::abs(script.Z[e].imag() / omega / about.chain.damping[e] - 1);
    }
    outcome.elements.push_back(element);
  }
}

void tell(const Case& about, const Pipeline& pipeline, double t_s, const Trace& trace) {
  double left = 0.0;
  int channel = 0;
  if (t_s >= about.change_s)
    for (int c = 0; c < about.channels(); ++c) {
      const double now = about.motion->envelope(c, t_s) / about.threshold(c);
      if (now > left) left = now, channel = c;
    }
  const Dwell dwell = pipeline.current();
  char text[200];
  std::snprintf(text, sizeof text, "%8.2f periods, true transient at most %.3g times what is allowed (%s), %s, ",
                (t_s - about.change_s) * about.frequency_hz, left,
                about.rig.channels[static_cast<std::size_t>(channel)].name.c_str(), to_string(dwell.state));
  trace(text + dwell.settling_reason);
}

void tell(const Case& about, const Dwell& dwell, const Outcome& outcome, const Trace& trace) {
  char text[300];
  std::snprintf(text, sizeof text, "oracle %.2f, verdict %.2f, data count from %.2f to %.2f periods; left %.3g in %s",
                outcome.oracle_s * about.frequency_hz, outcome.verdict_s * about.frequency_hz,
                (dwell.settled_s - about.change_s) * about.frequency_hz,
                (dwell.end_s - about.change_s) * about.frequency_hz, outcome.left,
                outcome.left_channel < 0
                    ? "none"
                    : about.rig.channels[static_cast<std::size_t>(outcome.left_channel)].name.c_str());
  trace(text);
  for (const Complex& pole : about.motion->natural()) {
    std::snprintf(text, sizeof text, "natural oscillation at %.5g rad/s, decaying at %.4g /s", pole.imag(),
                  -pole.real());
    trace(text);
  }
  for (std::size_t e = 0; e < outcome.elements.size(); ++e) {
    const ElementOutcome& element = outcome.elements[e];
    std::snprintf(text, sizeof text,
                  "element %zu: |d|/sigma %.3g, |Z|/sigma %.3g; error/bound c %.2f r %.2f; error/U95 c %.2f r %.2f; %s",
                  e + 1, element.snr_d, element.snr_Z, element.c_error, element.r_error, element.c_U95, element.r_U95,
                  element.reported ? "reported" : dwell.elements[e].reason.c_str());
    trace(text);
    for (const BudgetShare& share : dwell.elements[e].budget)
      if (share.stiffness_share > 0.1 || share.damping_share > 0.1) {
        std::snprintf(text, sizeof text, "    %s: %.2f of c, %.2f of r", share.source.c_str(), share.stiffness_share,
                      share.damping_share);
        trace(text);
      }
  }
  for (const Warning& warning : dwell.warnings) trace("warning: " + warning.what);
  for (const Doubt& doubt : dwell.doubts) trace("doubt: " + doubt.what);
}

Outcome play(const Case& about, const Trace& trace) {
  Outcome outcome;
  outcome.index = about.index;
  outcome.masses = about.chain.mass_count();
  outcome.remark = about.remark;
  outcome.period_s = about.period_s();
  outcome.tau_periods = about.motion->time_constant_s() * about.frequency_hz;
  const double oracle_s = oracle_of(about), period_s = about.period_s();
  outcome.oracle_s = oracle_s - about.change_s;
  const double give_up_s = oracle_s + kGiveUp * std::max(10 * period_s, about.motion->time_constant_s());

  Pipeline pipeline(about.rig);
  Player player(about);
  bool old_drive = about.change_s > 0;  // what is said still concerns the drive before
  double verdict_s = 0.0, told_s = 0.0;
  int index = 0;  // of the dwell with that verdict
  for (;;) {
    pipeline.push(player.next());
    const double t_s = player.now_s();
    if (trace && t_s > told_s) {
      tell(about, pipeline, t_s, trace);
      told_s = t_s + (outcome.settled ? 5.0 : 0.25) * period_s;
    }
    if (t_s < about.change_s) continue;
    const bool measuring = pipeline.state() == State::measuring;
    if (!measuring) {
      old_drive = false;
      if (!outcome.settled && t_s > give_up_s) return outcome;
      if (outcome.settled && pipeline.state() == State::settling && pipeline.current().index.value_or(0) == index) {
        // An early verdict remains one; how late the rig has settled is told by the last.
        if (verdict_s > about.change_s) judge_left(about, verdict_s, outcome);
        ++outcome.taken_back;
        outcome.settled = false;
        if (trace) trace("verdict taken back: " + pipeline.current().settling_reason);
      }
      if (outcome.settled) {
        if (verdict_s > about.change_s + kOldVerdict * period_s || about.change_s == 0) {
          outcome.rearmed = true;
          judge_left(about, verdict_s, outcome);
          outcome.verdict_s = verdict_s - about.change_s;
          if (trace) trace("left measuring in a steady drive: " + pipeline.current().settling_reason);
          return outcome;
        }
        outcome.settled = false;  // that was the drive before
      }
      continue;
    }
    if (!outcome.settled && (!old_drive || t_s > about.change_s + kOldVerdict * period_s)) {
      outcome.settled = true;
      verdict_s = old_drive ? about.change_s : t_s;
      index = pipeline.current().index.value_or(0);
    }
    if (outcome.settled && t_s > verdict_s + about.hold_periods * period_s) break;
  }
  outcome.verdict_s = verdict_s - about.change_s;
  judge_left(about, verdict_s, outcome);
  if (!(pipeline.finish() & kCompleted)) return outcome;
  Dwell dwell = pipeline.completed();
  if (!std::isfinite(dwell.settled_s)) return outcome;
  outcome.completed = true;
  outcome.doubted = !dwell.doubts.empty();
  judge_elements(about, dwell, outcome);
  if (trace) tell(about, dwell, outcome, trace);
  return outcome;
}

}  // namespace

Outcome play_dwell(const Case& about, const Trace& trace) {
  const double began_s = cpu_s();
  Outcome outcome = play(about, trace);
  outcome.cpu_s = cpu_s() - began_s;
  return outcome;
}

}  // namespace dwell::study
