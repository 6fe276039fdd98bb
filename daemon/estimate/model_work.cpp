#include "daemon/estimate/model_work.hpp"

#include <algorithm>
#include <utility>

#include "core/motion/dwell_agreement.hpp"

namespace dwell {

ModelWork::ModelWork(std::shared_ptr<LongWork> work)
    : work_(std::move(work)), transient_(work_->rig), verification_(work_->rig) {}

void ModelWork::turn(const Dwell& now, std::uint64_t position) {
  if (auto job = work_->slot.collect(); job && std::exchange(out_, false)) {
    if (auto* const transient = std::get_if<TransientJob>(&*job)) {
      const auto before = transient_.newest();
      transient_.take_back(std::move(*transient));
      if (transient_.newest() != before) news_ = transient_.newest();
    } else {
      verification_.take_back(std::move(std::get<VerificationJob>(*job)));
      news_ = verification_.newest();
      keep_verdict();
    }
  }
  transient_.follow(now);
  verification_.follow(now, position);
  if (!work_->slot.free()) return;
  // A transient first: the operator waits for its numbers.
  if (transient_.due()) {
    work_->slot.put(transient_.hand_over());
    out_ = true;
  } else if (verification_.due()) {
    work_->slot.put(verification_.hand_over());
    out_ = true;
  }
}

// Readers may still hold the list, so it is replaced and never altered.
void ModelWork::keep_verdict() {
  const auto& newest = verification_.newest();
  if (!newest || !newest->dwell.index) return;
  auto models = models_ ? std::make_shared<VerifiedModels>(*models_) : std::make_shared<VerifiedModels>();
  const auto at = std::lower_bound(models->begin(), models->end(), *newest->dwell.index,
                                   [](const VerifiedModel& m, int dwell) { return m.dwell < dwell; });
  const VerifiedModel kept{*newest->dwell.index, in_short(newest->verification)};
  if (at != models->end() && at->dwell == kept.dwell)
    *at = kept;
  else
    models->insert(at, kept);
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
