#include "tests/study/motion_times.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "core/dwell/pipeline.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_recorder.hpp"
#include "tests/study/recording.hpp"
#include "tests/study/signal.hpp"

namespace dwell::study {
namespace {

constexpr double kNarrow = 0.1;
constexpr double kNormal95 = 1.96;
constexpr double kGiveUp_periods = 400;
constexpr double kGivenUp = 6.0;  // times the bound
constexpr double kGrid = 1.15, kFineGrid = 1.05;
constexpr std::size_t kMostUntilKnown = 20'000;

// The dwell as it is in the end; its verdict on the axis of the stamps.
Dwell harmonic(const Case& about) {
  Pipeline pipeline(about.rig);
  Player player(about);
  double first_s = NAN, until_s = about.change_s + kGiveUp_periods * about.period_s();
  bool measuring = false;
  while (player.now_s() < until_s) {
    const Record record = player.next();
    if (std::isnan(first_s)) first_s = 1e-9 * static_cast<double>(record.t_ns);
    pipeline.push(record);
    if (!measuring && pipeline.state() == State::measuring) {
      measuring = true;
      until_s = player.now_s() + about.hold_periods * about.period_s();
    }
  }
  Dwell dwell = (pipeline.finish() & kCompleted) != 0 ? pipeline.completed() : pipeline.current();
  dwell.verdict_s += first_s;
  return dwell;
}

bool reported(const Dwell& dwell, std::size_t e) { return dwell.elements[e].identifiable; }

bool bound_is_narrow(const Case& about, const Dwell& dwell, double until_s) {
  const std::vector<ReadingAt> readings = readings_at(about, about.change_s, until_s, kMostUntilKnown);
  const bool from_rest = about.remark.find("from rest") != std::string::npos;
  const auto count = static_cast<Eigen::Index>(2 * dwell.elements.size());
  const Eigen::VectorXd u = bound_of(derivatives(world_of(about), readings, from_rest), count);
  for (std::size_t e = 0; e < dwell.elements.size(); ++e)
    if (reported(dwell, e) && !(kNormal95 * u.segment(static_cast<Eigen::Index>(2 * e), 2).maxCoeff() <= kNarrow))
      return false;
  return true;
}

bool estimate_is_narrow(const Case& about, const Dwell& dwell, double until_s) {
  MotionRecorder recorder(about.rig);
  Player player(about);
  for (Record record = player.next(); player.now_s() < until_s; record = player.next()) recorder.take(record);
  const MotionEstimate estimate = estimate_motion(about.rig, recorder.data());
  if (!estimate.reason.empty()) return false;
  for (std::size_t e = 0; e < dwell.elements.size(); ++e) {
    const ElementEstimate& seen = estimate.elements[e];
    if (reported(dwell, e) && !(seen.identifiable && seen.stiffness.U95 <= kNarrow * std::abs(seen.stiffness.value) &&
                                seen.damping.U95 <= kNarrow * std::abs(seen.damping.value)))
      return false;
  }
  return true;
}

}  // namespace

MotionTimes play_times(const Case& about) {
  MotionTimes out;
  out.noise = 0.0;
  for (int c = 0; c < about.channels(); ++c)
    out.noise =
        std::max(out.noise, about.lines[static_cast<std::size_t>(c)].noise() / std::abs(about.motion->phasor(c, 1)));
  out.damping_ratio = INFINITY;
  for (const Complex& lambda : about.motion->natural())
    out.damping_ratio = std::min(out.damping_ratio, -lambda.real() / std::abs(lambda));
  const Dwell dwell = harmonic(about);
  bool any = false;
  for (std::size_t e = 0; e < dwell.elements.size(); ++e) any = any || reported(dwell, e);
  if (!any || !std::isfinite(dwell.verdict_s)) return out;
  out.harmonic_s = dwell.verdict_s - about.change_s;
  const double end_s = out.harmonic_s + about.hold_periods * about.period_s();
  double bound_s = 0.05 * about.period_s();
  while (bound_s < end_s && !bound_is_narrow(about, dwell, about.change_s + bound_s)) bound_s *= kFineGrid;
  if (bound_s >= end_s) return out;
  out.bound_s = bound_s;
  const auto known = [&](double so_far_s) { return estimate_is_narrow(about, dwell, about.change_s + so_far_s); };
  double coarse_s = bound_s;
  while (coarse_s <= kGivenUp * bound_s && !known(coarse_s)) coarse_s *= kGrid;
  if (coarse_s > kGivenUp * bound_s) return out;
  // Within the last step of 15 %, in steps of 5 %.
  out.seen_s = coarse_s;
  for (double fine_s = coarse_s / kGrid * kFineGrid; coarse_s > bound_s && fine_s < coarse_s; fine_s *= kFineGrid)
    if (known(fine_s)) {
      out.seen_s = fine_s;
      break;
    }
  return out;
}

}  // namespace dwell::study
