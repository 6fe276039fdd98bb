#include "tests/study/motion_witness.hpp"

#include "core/dwell/pipeline.hpp"
#include "core/motion/dwell_agreement.hpp"
#include "core/motion/motion_estimate.hpp"
#include "tests/study/any_motion.hpp"
#include "tests/study/recording.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {
namespace {

std::vector<Dwell> dwells_of(const Case& about, double until_s) {
  Pipeline pipeline(about.rig);
  Player player(about);
  std::vector<Dwell> dwells;
  do {
    if (pipeline.push(player.next()) & kCompleted) dwells.push_back(pipeline.completed());
  } while (player.now_s() < until_s);
  if (pipeline.finish() & kCompleted) dwells.push_back(pipeline.completed());
  return dwells;
}

}  // namespace

std::vector<std::string> objections_of_motion(const Case& about, double until_s) {
  const MotionEstimate motion = estimate_motion(about.rig, recorded(about, until_s).data());
  if (!motion.reason.empty()) return {"no coefficients: " + motion.reason};
  std::vector<std::string> lines = motion.warnings;
  for (const Dwell& dwell : dwells_of(about, until_s)) {
    if (const auto objection = objection_to(dwell, motion)) lines.push_back(objection->what);
    if (const auto with = agreement_of(motion, dwell); with && with->contradicts)
      lines.push_back(text("coefficients from %.2f periods on contradict: %s of element %d by %.2g of the joint U",
                           dwell.settled_s / about.period_s(), to_string(with->kind), with->element, with->over_U));
  }
  return lines;
}

}  // namespace dwell::study
