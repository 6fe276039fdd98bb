#include "daemon/ctl/model_check.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "core/motion/dwell_agreement.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {
namespace {


std::string objection_of(const TransientEstimate& of, const std::vector<Dwell>& dwells) {
  const auto dwell = std::find_if(dwells.begin(), dwells.end(), [&](const Dwell& one) { return one.index == of.dwell; });
  if (dwell == dwells.end() || !may_object(*dwell, of.estimate)) return {};
  const std::optional<Objection> objection = objection_to(*dwell, of.estimate);
  return objection ? objection->what : std::string();
}

// As one document, so that differences name their place in it.
std::string document(const std::string& kind, const std::string& from, const std::string& result) {
  return dump(Json{{kind, {{"from", Json::parse(from, nullptr, false)}, {"result", Json::parse(result, nullptr, false)}}}});
}

Finding finding_of(const record::StoredModel& stored, Difference difference) {
  return {stored.position, false, {}, std::move(difference)};
}

}  // namespace

record::Result<ModelCheck> ModelCheck::open(record::RunReader& run, const Rig& rig, double accuracy) {
  std::vector<PublishedEstimate> estimates;
  std::vector<PublishedVerification> verifications;
  std::uint64_t without = 0;
  std::size_t bytes = 0;
  std::string wrong;
  const auto keep = [&](const record::StoredModel& stored) -> tl::expected<void, std::string> {
    bytes += stored.from.size() + stored.result.size();
    if (bytes > kMostBytes)
      return tl::unexpected<std::string>("there are more than " + std::to_string(kMostBytes >> 20U) + " MiB of them");
    if (stored.kind == "verification") {
      auto of = verified_in(stored.from);
      if (!of) return tl::unexpected(of.error());
      if (of->given > VerificationsAgain::kMostReadings)
        return tl::unexpected("from " + std::to_string(of->given) + " readings; a verification takes " +
                              std::to_string(VerificationsAgain::kMostReadings) + " at most");
      verifications.push_back({stored, std::move(*of)});
      return {};
    }
    auto of = estimate_in(stored.from, rig);
    if (!of) return tl::unexpected(of.error());
    if (!*of) return ++without, tl::expected<void, std::string>();
    if ((*of)->given > EstimatesAgain::kMostReadings)
      return tl::unexpected("from " + std::to_string((*of)->given) + " readings; an estimate takes " +
                            std::to_string(EstimatesAgain::kMostReadings) + " at most");
    estimates.push_back({stored, std::move(**of)});
    return {};
  };
  const auto read = run.models([&](const record::StoredModel& stored) {
    if (const auto kept = keep(stored); !kept)
      wrong = "the " + stored.kind + " published at record " + std::to_string(stored.position) + ": " + kept.error();
    return wrong.empty();
  });
  if (!read) return tl::unexpected(read.error());
  if (!wrong.empty()) return tl::unexpected(wrong);
  return ModelCheck(rig, accuracy, std::move(estimates), std::move(verifications), without);
}

ModelCheck::ModelCheck(const Rig& rig, double accuracy, std::vector<PublishedEstimate> estimates,
                       std::vector<PublishedVerification> verifications, std::uint64_t without)
    : rig_(&rig),
      accuracy_(accuracy),
      estimates_(rig, std::move(estimates)),
      verifications_(std::move(verifications)),
      without_(without) {}

void ModelCheck::follow(std::span<const Record> taken, const Replay& replay) {
  std::uint64_t position = replay.position() - taken.size();
  for (const Record& record : taken) {
    ++position;
    if (!concerns_pipeline(record.kind)) continue;
    if (!origin_ns_) origin_ns_ = record.t_ns;
    estimates_.take(record, record.t_ns - *origin_ns_, position,
                    [this](const PublishedEstimate& published, TransientJob job) {
                      Again& again = again_.emplace_back(Again{published.stored});
                      compute([rig = rig_, &again, job = std::make_shared<TransientJob>(std::move(job))] {
                        job->run(*rig);
                        again.estimate = std::move(job->result);
                      });
                    });
  }
  verifications_.take(replay, origin_ns_.value_or(0), [this](const PublishedVerification& published, VerificationJob job) {
    Again& again = again_.emplace_back(Again{published.stored});
    compute([rig = rig_, accuracy = accuracy_, &again, job = std::make_shared<VerificationJob>(std::move(job))] {
      job->run(*rig, accuracy);
      again.entry = model_entry(job->result, *rig);
    });
  });
}

// One for each processor at once: more would wait with their readings.
void ModelCheck::compute(std::function<void()> work) {
  if (computing_.size() >= std::max(1U, std::thread::hardware_concurrency())) {
    computing_.front().get();
    computing_.pop_front();
  }
  computing_.push_back(std::async(std::launch::async, std::move(work)));
}

void ModelCheck::finish(const std::vector<Dwell>& dwells, ReplayFindings& to) {
  for (std::future<void>& one : computing_) one.get();
  computing_.clear();
  for (Again& again : again_) {
    if (again.estimate) {
      again.estimate->objection = objection_of(*again.estimate, dwells);
      again.entry = model_entry(*again.estimate, *rig_);
    }
    compare(again, to);
  }
  const auto not_computed = [&to](const record::StoredModel& stored) {
    to.add(finding_of(stored, {stored.kind, stored.from, "the replay has no such readings or no such dwell", kNaN, false}));
  };
  for (const PublishedEstimate& published : estimates_.left()) not_computed(published.stored);
  for (const PublishedVerification& published : verifications_.left()) not_computed(published.stored);
  if (without_ > 0)
    to.notes.push_back("estimates of an older program, which did not store all that they were made from: " +
                       std::to_string(without_) + "; not compared");
}

void ModelCheck::compare(const Again& again, ReplayFindings& to) const {
  const record::StoredModel& stored = again.stored;
  ++(stored.kind == "verification" ? to.verifications : to.estimates);
  if (stored.from == again.entry.from && stored.result == again.entry.result) {
    to.numbers += numbers_in(stored.result);
    return;
  }
  auto comparison = compare_results(document(stored.kind, stored.from, stored.result),
                                    document(stored.kind, again.entry.from, again.entry.result));
  if (!comparison) return to.add(finding_of(stored, {stored.kind, comparison.error(), "", kNaN, false}));
  to.numbers += comparison->numbers;
  for (Difference& difference : comparison->differences) to.add(finding_of(stored, std::move(difference)));
}

}  // namespace dwell::ctl
