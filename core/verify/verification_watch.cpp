#include "core/verify/verification_watch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/instants.hpp"
#include "core/verify/verification.hpp"

namespace dwell {
namespace {

// Readings of all channels together: at most 60 000 for verify_model(), and room for those before a hold.
constexpr std::size_t kMostKept = 64'000;
// Periods of the nominal drive before the hold that belong to the evidence: it begins a period of the slowest natural
// oscillation before, which may be as slow as this.
constexpr double kBeforeDwell = 10.0;
// From one verification to the next the dwell's data grow by this factor: an hour of dwell is verified a dozen times.
constexpr double kVerifyGrowth = 2.0;

}  // namespace

void VerificationJob::run(const Rig& rig, double accuracy) {
  std::vector<ChannelReadings> before(rig.channels.size());
  for (const HoldRecord::Reading& reading : *evidence) {
    ChannelReadings& channel = before[static_cast<std::size_t>(reading.channel)];
    channel.t_ns.push_back(reading.t_ns);
    channel.value.push_back(reading.value);
  }
  result.verification = verify_model(rig, result.dwell, before, accuracy);
  if (!asks_for_causes(result.verification, result.dwell)) return;
  if (!causes) causes = std::make_shared<const Causes>(find_causes(rig, before, INT64_MAX));
  tell_causes(*causes, result.verification);
}

VerificationWatch::VerificationWatch(const Rig& rig)
    : period_s_(1.0 / rig.excitation.frequency_hz), record_(kMostKept) {}

void VerificationWatch::take(const SampleHistory& history, std::int64_t origin_ns) noexcept {
  for (next_ = std::max(next_, history.begin()); next_ < history.end(); ++next_) {
    const SampleHistory::Sample& sample = history[next_];
    if (record_.push({sample.t_ns - origin_ns, sample.value, sample.channel})) last_ = next_ + 1;
  }
}

VerificationJob VerificationWatch::job_of(const Hold& hold, const Dwell& dwell, std::uint64_t position, bool ended) {
  VerificationJob job{hold.evidence, {dwell, {}}, nullptr};
  VerifiedDwell& of = job.result;
  of.position = position;
  of.ended = ended;
  of.last = hold.last;
  of.given = hold.evidence->size();
  if (hold.evidence->empty()) return job;
  of.from_s = to_s(hold.evidence->front().t_ns);
  of.until_s = to_s(hold.evidence->back().t_ns);
  return job;
}

void VerificationWatch::follow(const Dwell& now, std::uint64_t position) {
  const bool on = now.index && (now.state == State::settling || now.state == State::measuring);
  if (!on) {
    if (now_.dwell) {
      before_ = std::exchange(now_, {});
      record_.roll();
    }
    return;
  }
  if (now.index != now_.dwell || now.start_s != now_.start_s) {
    if (now_.dwell && now.index != now_.dwell) before_ = now_;
    now_ = {now.index, now.start_s, nullptr, 0, 0.0};
    record_.begin(to_ns(now.start_s - kBeforeDwell * period_s_));
  }
  if (!std::isfinite(now.settled_s)) {
    // Never settled, or the verdict was taken back: the evidence goes on.
    if (now_.evidence && record_.resume()) now_.evidence.reset();
    return;
  }
  if (!now_.evidence) {
    now_.evidence = std::make_shared<const std::vector<HoldRecord::Reading>>(record_.readings());
    now_.last = last_;
    now_.verified_s = 0.0;
    record_.roll();
  }
  const double length_s = now.end_s - now.settled_s;
  const bool waits = std::any_of(waiting_.begin(), waiting_.end(),
                                 [this](const VerificationJob& job) { return job.evidence == now_.evidence; });
  if (now.elements.empty() || waits || !(length_s >= kVerifyGrowth * now_.verified_s)) return;
  now_.verified_s = length_s;
  enqueue(job_of(now_, now, position, false));
}

// In place of a waiting job of the same dwell: this one has more data.
void VerificationWatch::enqueue(VerificationJob job) {
  std::erase_if(waiting_, [&job](const VerificationJob& other) { return other.evidence == job.evidence; });
  if (waiting_.size() == kMostWaiting) waiting_.pop_front();
  waiting_.push_back(std::move(job));
}

void VerificationWatch::ended(const Dwell& dwell, std::uint64_t position) {
  const Hold& of = dwell.index == now_.dwell ? now_ : before_;
  if (of.evidence && dwell.index == of.dwell && std::isfinite(dwell.settled_s))
    enqueue(job_of(of, dwell, position, true));
}

VerificationJob VerificationWatch::hand_over() {
  VerificationJob job = std::move(waiting_.front());
  waiting_.pop_front();
  if (job.evidence == explained_) job.causes = causes_;
  out_ = true;
  return job;
}

void VerificationWatch::take_back(VerificationJob job) {
  out_ = false;
  if (job.causes) {
    explained_ = job.evidence;
    causes_ = job.causes;
  }
  newest_ = std::make_shared<const VerifiedDwell>(std::move(job.result));
}

}  // namespace dwell
