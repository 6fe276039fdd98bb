#include "daemon/estimate/model_work.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "core/dwell/readings_at_fault.hpp"
#include "core/motion/dwell_agreement.hpp"

namespace dwell {

ModelWork::ModelWork(std::shared_ptr<LongWork> work)
    : work_(std::move(work)), transient_(work_->rig), verification_(work_->rig) {}

void ModelWork::ended(const Dwell& dwell, std::uint64_t position) {
  transient_.ended(dwell);
  verification_.ended(dwell, position);
}

void ModelWork::turn(const Dwell& now, std::uint64_t position, const Pipeline& pipeline) {
  // One a turn, since take_news() holds one.
  if (auto estimate = work_->estimates.collect()) {
    if (std::exchange(estimate_out_, false)) take_back(std::move(*estimate));
  } else if (auto verified = work_->verifications.collect(); verified && std::exchange(verification_out_, false)) {
    take_back(std::move(*verified));
  }
  transient_.follow(now, readings_at_fault(work_->rig, pipeline, now));
  verification_.follow(now, position);
  if (const auto& newest = transient_.newest()) object(now, newest->estimate);
  if (transient_.due() && work_->estimates.free()) {
    work_->estimates.put(transient_.hand_over());
    estimate_out_ = true;
  }
  if (verification_.due() && work_->verifications.free()) {
    work_->verifications.put(verification_.hand_over());
    verification_out_ = true;
  }
}

void ModelWork::take_back(TransientJob job) {
  if (job.ended) {
    job.result.dwell = job.dwell;
    job.result.objection = object(*job.ended, job.result.estimate);
  }
  if (auto estimate = transient_.take_back(std::move(job))) news_ = std::move(estimate);
}

void ModelWork::take_back(VerificationJob job) {
  verification_.take_back(std::move(job));
  news_ = verification_.newest();
  const VerifiedDwell& of = *verification_.newest();
  if (!of.dwell.index) return;
  change_verdict(*of.dwell.index, [&](ModelVerdict& verdict) {
    std::string objection = std::move(verdict.objection);
    verdict = in_short(of.verification);
    verdict.objection = std::move(objection);
  });
}

// What any motion holds against a dwell that has settled; empty: nothing. It becomes part of the dwell's verdict. An
// estimate that says nothing about the chain changes no verdict.
std::string ModelWork::object(const Dwell& dwell, const MotionEstimate& motion) {
  if (!may_object(dwell, motion)) return {};
  const std::optional<Objection> objection = objection_to(dwell, motion);
  std::string what = objection ? objection->what : std::string();
  const VerifiedModel* const known = verdict_on(models_.get(), *dwell.index);
  const bool is_new = known != nullptr ? known->model.objection != what : !what.empty();
  if (is_new) change_verdict(*dwell.index, [&](ModelVerdict& verdict) { verdict.objection = what; });
  return what;
}

// Readers may still hold the list, so it is replaced and never altered.
template <class Change>
void ModelWork::change_verdict(int dwell, Change change) {
  auto models = models_ ? std::make_shared<VerifiedModels>(*models_) : std::make_shared<VerifiedModels>();
  auto at = std::lower_bound(models->begin(), models->end(), dwell,
                             [](const VerifiedModel& m, int index) { return m.dwell < index; });
  if (at == models->end() || at->dwell != dwell) {
    at = models->insert(at, VerifiedModel{dwell, {}});
    at->model.asked = work_->accuracy;
  }
  change(at->model);
  if (models->size() > kMostVerdicts) models->erase(models->begin());
  models_ = std::move(models);
}

void ModelWork::show(const Dwell& now, Snapshot& to) const {
  to.transient = transient_.newest();
  to.transient_agreement = to.transient ? agreement_of(to.transient->estimate, now) : std::nullopt;
  to.verified = verification_.newest();
  to.models = models_;
}

}  // namespace dwell
