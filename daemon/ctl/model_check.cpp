#include "daemon/ctl/model_check.hpp"

#include <algorithm>
#include <thread>
#include <utility>

#include "core/motion/dwell_agreement.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {
namespace {

// What the estimate holds against its dwell; nullopt: that dwell does not end in the replay.
std::optional<std::string> objection_of(const TransientEstimate& of, const std::vector<Dwell>& dwells) {
  if (!of.dwell) return std::string();
  const auto dwell =
      std::find_if(dwells.begin(), dwells.end(), [&](const Dwell& one) { return one.index == of.dwell; });
  if (dwell == dwells.end()) return std::nullopt;
  if (!may_object(*dwell, of.estimate)) return std::string();
  const std::optional<Objection> objection = objection_to(*dwell, of.estimate);
  return objection ? objection->what : std::string();
}

// As one document, so that differences name their place in it.
std::string document(const std::string& kind, const std::string& from, const std::string& result) {
  return dump(
      Json{{kind, {{"from", Json::parse(from, nullptr, false)}, {"result", Json::parse(result, nullptr, false)}}}});
}

Finding finding_of(const record::StoredModel& stored, Difference difference) {
  return {stored.position, false, {}, std::move(difference)};
}

}  // namespace

tl::expected<void, std::string> ModelCheck::sort(const record::StoredModel& stored, const Rig& rig, Published& to) {
  const auto too_many = [](std::size_t given, std::size_t most) {
    return tl::unexpected("from " + std::to_string(given) + " readings; one takes " + std::to_string(most) +
                          " at most");
  };
  if (stored.kind == "verification") {
    auto of = verified_in(stored.from);
    if (!of) return tl::unexpected(of.error());
    if (of->given > VerificationsAgain::kMostReadings) return too_many(of->given, VerificationsAgain::kMostReadings);
    const Json result = Json::parse(stored.result, nullptr, false);
    if (const auto index = result.find("dwell"); index != result.end() && index->is_number_integer())
      of->dwell.index = index->get<int>();
    to.verifications.push_back({stored, std::move(*of)});
    return {};
  }
  auto of = estimate_in(stored.from, rig);
  if (!of) return tl::unexpected(of.error());
  if (!*of) {
    ++to.older;
    return {};
  }
  if ((*of)->given > EstimatesAgain::kMostReadings) return too_many((*of)->given, EstimatesAgain::kMostReadings);
  to.estimates.push_back({stored, std::move(**of)});
  return {};
}

record::Result<ModelCheck> ModelCheck::open(record::RunReader& run, const Rig& rig, double accuracy) {
  Published published;
  std::size_t bytes = 0, entries = 0;
  const auto read = run.models([&](const record::StoredModel& stored) {
    bytes += stored.from.size() + stored.result.size();
    if (bytes > kMostBytes || ++entries > kMostEntries) return false;
    if (const auto sorted = sort(stored, rig, published); !sorted)
      published.wrong.push_back(finding_of(stored, {stored.kind, sorted.error(), "", kNaN, false}));
    return true;
  });
  if (!read) return tl::unexpected(read.error());
  if (bytes > kMostBytes || entries > kMostEntries)
    return tl::unexpected("the run has more than " + std::to_string(kMostEntries) +
                          " estimates and verifications, or " + std::to_string(kMostBytes >> 20U) +
                          " MiB of them: more than are compared");
  return ModelCheck(rig, accuracy, std::move(published));
}

ModelCheck::ModelCheck(const Rig& rig, double accuracy, Published published)
    : rig_(&rig),
      accuracy_(accuracy),
      estimates_(rig, std::move(published.estimates)),
      verifications_(std::move(published.verifications)),
      older_(published.older),
      wrong_(std::move(published.wrong)) {}

void ModelCheck::follow(std::span<const Record> taken, const Replay& replay) {
  std::uint64_t position = replay.position() - taken.size();
  for (const Record& record : taken) {
    ++position;
    if (!concerns_pipeline(record.kind)) continue;
    if (!origin_ns_) origin_ns_ = record.t_ns;
    estimates_.take(record, record.t_ns - *origin_ns_, position, [this](record::StoredModel stored, TransientJob job) {
      job.stop = stop_.get_token();
      Again& again = again_.emplace_back(Again{std::move(stored)});
      compute([rig = rig_, &again, job = std::make_shared<TransientJob>(std::move(job))] {
        job->run(*rig);
        again.estimate = std::move(job->result);
      });
    });
  }
  verifications_.take(replay, origin_ns_.value_or(0), [this](record::StoredModel stored, VerificationJob job) {
    Again& again = again_.emplace_back(Again{std::move(stored)});
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
  for (Finding& finding : wrong_) to.add(std::move(finding));
  const auto not_compared = [&to](const record::StoredModel& stored, const char* why) {
    to.add(finding_of(stored, {stored.kind, stored.from, why, kNaN, false}));
  };
  for (Again& again : again_) {
    if (again.estimate) {
      auto objection = objection_of(*again.estimate, dwells);
      if (!objection) {
        not_compared(again.stored, "no such dwell ends in the replay");
        continue;
      }
      again.estimate->objection = std::move(*objection);
      again.entry = model_entry(*again.estimate, *rig_);
    }
    compare(again, to);
  }
  for (const PublishedEstimate& published : estimates_.left())
    not_compared(published.stored, "the stream has no such reading");
  for (const PublishedVerification& published : verifications_.left())
    not_compared(published.stored, "the replay has no such dwell, or not these readings");
  if (older_ > 0)
    to.notes.push_back("estimates of an older program, which did not store all that they were made from: " +
                       std::to_string(older_) + "; not compared");
}

void ModelCheck::compare(const Again& again, ReplayFindings& to) const {
  const record::StoredModel& stored = again.stored;
  ++(stored.kind == "verification" ? to.verifications : to.estimates);
  if (stored.from == again.entry.from && stored.result == again.entry.result) {
    to.numbers += numbers_in(stored.from) + numbers_in(stored.result);
    return;
  }
  auto comparison = compare_results(document(stored.kind, stored.from, stored.result),
                                    document(stored.kind, again.entry.from, again.entry.result));
  if (!comparison) return to.add(finding_of(stored, {stored.kind, comparison.error(), "", kNaN, false}));
  to.numbers += comparison->numbers;
  for (Difference& difference : comparison->differences) to.add(finding_of(stored, std::move(difference)));
}

}  // namespace dwell::ctl
