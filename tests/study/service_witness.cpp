#include "tests/study/service_witness.hpp"

#include <cmath>

#include "core/dwell/pipeline.hpp"
#include "core/dwell/readings_at_fault.hpp"
#include "core/motion/dwell_agreement.hpp"
#include "core/motion/transient_watch.hpp"
#include "core/verify/verification_watch.hpp"
#include "tests/study/recording.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {
namespace {

constexpr double kAccuracy = 0.05;  // the rig file's default

class Service {
 public:
  explicit Service(const Case& about) : rig_(about.rig), pipeline_(rig_), transient_(rig_), verification_(rig_) {}

  void take(const Record& record, double now_s) {
    const bool completed = (pipeline_.push(record) & kCompleted) != 0;
    transient_.take(record, record.t_ns);
    if (completed) ended();
    if (now_s < next_s_) return;
    next_s_ = now_s + rig_.update_s;
    verification_.take(pipeline_.readings(), 0);
    const Dwell now = pipeline_.current();
    transient_.follow(now, readings_at_fault(rig_, pipeline_, now));
    verification_.follow(now);
    if (const auto& newest = transient_.newest(); newest && std::isfinite(now.settled_s)) object(now, newest->estimate);
    estimate();
    verify();
  }
  std::vector<std::string> end() {
    if (pipeline_.finish() & kCompleted) ended();
    if (const auto& of = verification_.newest()) tell(of->verification);
    return std::move(lines_);
  }

 private:
  void ended() {
    transient_.ended(pipeline_.completed());
    verification_.ended(pipeline_.completed());
    estimate();
    verify();
  }
  void verify() {
    if (!verification_.due()) return;
    VerificationJob job = verification_.hand_over();
    job.run(rig_, kAccuracy);
    verification_.take_back(std::move(job));
  }
  void estimate() {
    if (!transient_.due()) return;
    TransientJob job = transient_.hand_over();
    job.run(rig_);
    if (job.ended) compare(*job.ended, job.result.estimate);
    (void)transient_.take_back(std::move(job));
  }
  void object(const Dwell& dwell, const MotionEstimate& motion) {
    if (motion.elements.empty() && !motion.contradicted) return;
    const auto objection = objection_to(dwell, motion);
    if (objection && (lines_.empty() || lines_.back() != objection->what)) lines_.push_back(objection->what);
  }
  void compare(const Dwell& dwell, const MotionEstimate& motion) {
    object(dwell, motion);
    if (const auto with = agreement_of(motion, dwell); with && with->contradicts)
      lines_.push_back(text("any motion: contradicts: %s of element %d by %.2g of the joint U", to_string(with->kind),
                            with->element, with->over_U));
  }
  void tell(const Verification& of) {
    if (of.consistent.value_or(true) && of.verdict != Verdict::not_adequate) return;
    for (const std::string& reason : of.reasons) lines_.push_back("verification: " + reason);
    for (const MissingTerm& term : of.missing) lines_.push_back("verification: better explained with " + term.told);
  }

  const Rig& rig_;
  Pipeline pipeline_;
  TransientWatch transient_;
  VerificationWatch verification_;
  double next_s_ = 0.0;
  std::vector<std::string> lines_;
};

}  // namespace

std::vector<std::string> objections_of_service(const Case& about, double until_s) {
  Service service(about);
  Player player(about);
  do {
    const Record record = player.next();
    service.take(record, player.now_s());
  } while (player.now_s() < until_s);
  return service.end();
}

}  // namespace dwell::study
