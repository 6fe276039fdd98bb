#include "tests/study/motion_witness.hpp"

#include <cmath>

#include "core/dwell/pipeline.hpp"
#include "core/motion/dwell_agreement.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_recorder.hpp"
#include "tests/study/recording.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {

void tell_motion(const Case& about, double until_s, const Trace& trace) {
  Pipeline pipeline(about.rig);
  MotionRecorder recorder(about.rig);
  Player player(about);
  std::vector<Dwell> dwells;
  do {
    const Record record = player.next();
    recorder.take(record);
    if (pipeline.push(record) & kCompleted) dwells.push_back(pipeline.completed());
  } while (player.now_s() < until_s);
  if (pipeline.finish() & kCompleted) dwells.push_back(pipeline.completed());
  const MotionEstimate motion = estimate_motion(about.rig, recorder.data(), {.missing = false});
  if (!motion.reason.empty()) return trace("any motion: no coefficients: " + motion.reason);
  for (const std::string& line : motion.warnings) trace("any motion: warning: " + line);
  for (const Dwell& dwell : dwells)
    if (const double e_n = agreement_e_n(motion, dwell); std::isfinite(e_n))
      trace(text("any motion: E_n %.2g against the dwell from %.2f periods on%s", e_n,
                 dwell.settled_s / about.period_s(), e_n > 1 ? ": they contradict each other" : ""));
}

}  // namespace dwell::study
