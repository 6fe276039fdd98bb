#include "core/motion/transient_watch.hpp"

#include <cmath>
#include <utility>

#include "core/base/instants.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/motion/motion_model.hpp"
#include "core/motion/motion_recorder.hpp"

namespace dwell {
namespace {

// Periods of the nominal drive before the hold that belong to its stretch: the onset may lie in the hold's first
// window, and the estimate needs a period before the onset.
constexpr double kBeforeHold = 1.5;
// Periods after the hold's beginning before the first estimate: with fewer most rigs' coefficients are not determined.
constexpr double kFirstAfter = 2.0;
// From one estimate to the next the readings grow by this factor. All together they cost 1/(1 - 1/1.5) = 3 times the
// last. Closer to 1: newer numbers, and more work; 2: twice the last, and numbers up to half the stretch old.
constexpr double kEstimateGrowth = 1.5;
// The same, once an estimate has fitted the chain anew with all that may be missing, which costs ten times as much.
constexpr double kGrowthAnew = 4.0;
// Of the readings that an estimate may take, this part is enough for the last one: 14 000 of a table and two masses,
// some seconds where they come irregularly, ten times as long where they contradict the chain. With all of them a
// processor is busy for minutes after each dwell. Halved, less of the dwell has a say.
constexpr double kPartOfLast = 0.2;
// If a hold of so many periods ends while the dwell settles, the drive has changed, and another stretch begins. A ramp
// leaves a hold every period. Longer: an operator's change of the drive goes unnoticed. Shorter: a slow ramp is torn.
constexpr double kSteadyHold = 8.0;

std::size_t most_readings(const Rig& rig) {
  return std::max<std::size_t>(1, MotionOptions{}.most_work / static_cast<std::size_t>(MotionModel(rig, {}).states()));
}

}  // namespace

void TransientJob::run(const Rig& rig) {
  MotionRecorder recorder(rig);
  for (const HoldRecord::Reading& reading : readings)
    recorder.take({.t_ns = reading.t_ns,
                   .value = reading.value,
                   .t_half_ns = reading.half_ns,
                   .channel = static_cast<std::uint16_t>(reading.channel)});
  MotionOptions options;
  options.at_fault = result.at_fault;
  options.anew = result.may_search;
  options.stop = stop;
  result.estimate = estimate_motion(rig, recorder.data(), options);
}

TransientWatch::~TransientWatch() {
  stale_.request_stop();
  of_last_.request_stop();
}

TransientWatch::TransientWatch(const Rig& rig)
    : period_s_(1.0 / rig.excitation.frequency_hz),
      most_of_last_(static_cast<std::size_t>(kPartOfLast * static_cast<double>(most_readings(rig)))),
      record_(most_readings(rig)) {
  for (const Channel& channel : rig.channels) counts_.push_back(channel.measures != Quantity::auxiliary);
}

void TransientWatch::take(const Record& record, std::int64_t t_ns, std::uint64_t position) noexcept {
  if (record.kind != Kind::sample || record.channel >= counts_.size() || !counts_[record.channel]) return;
  now_s_ = to_s(t_ns);
  if (phase_ == Phase::gathering && settled() && record_.size() >= most_of_last_) phase_ = Phase::complete;
  if (phase_ != Phase::complete && record_.push({t_ns, record.value, record.channel, record.t_half_ns}))
    last_ = position;
}

bool TransientWatch::settled() const noexcept { return std::isfinite(stretch_.settled_s); }

void TransientWatch::follow(const Dwell& now, std::vector<ChannelFault> at_fault) {
  const bool on = now.index && (now.state == State::settling || now.state == State::measuring);
  if (!on || !std::isfinite(now.start_s)) return wait();
  const bool other_drive = now.start_s - stretch_.hold_s >= kSteadyHold * period_s_;
  if (now.index != stretch_.dwell || other_drive) begin(now);
  stretch_.hold_s = now.start_s;
  stretch_.settled_s = now.settled_s;
  at_fault_ = std::move(at_fault);
}

void TransientWatch::wait() {
  if (phase_ == Phase::waiting) return;
  keep_for_last();
  stale_.request_stop();
  phase_ = Phase::waiting;
  record_.roll();
  stretch_.dwell.reset();
  newest_.reset();
}

void TransientWatch::begin(const Dwell& now) {
  if (now.index != stretch_.dwell) {
    if (phase_ != Phase::waiting) keep_for_last();
    newest_.reset();
  }
  stale_.request_stop();
  stretch_ = {.dwell = now.index, .number = stretch_.number + 1, .start_s = now.start_s};
  record_.begin(to_ns(now.start_s - kBeforeHold * period_s_));
  phase_ = Phase::gathering;
}

void TransientWatch::keep_for_last() {
  unreported_.reset();
  if (record_.size() > 0 && record_.size() <= most_of_last_) unreported_ = job();
}

void TransientWatch::ended(const Dwell& dwell) {
  if (dwell.index == stretch_.dwell) wait();
  if (!unreported_ || unreported_->dwell != dwell.index) return;
  if (std::isfinite(dwell.settled_s)) {
    last_job_ = std::move(unreported_);
    last_job_->ended = std::make_shared<const Dwell>(dwell);
  }
  unreported_.reset();
}

bool TransientWatch::due() const noexcept {
  if (out_) return false;
  if (last_job_) return true;
  if (phase_ == Phase::waiting) return false;
  const bool owed = stretch_.anew == AnewSearch::put_off;
  if (phase_ == Phase::complete || settled()) return owed;
  const std::size_t size = record_.size(), handed = stretch_.handed;
  if (handed == 0) return size > 0 && (record_.full() || now_s_ - stretch_.start_s >= kFirstAfter * period_s_);
  const double growth = stretch_.anew == AnewSearch::done ? kGrowthAnew : kEstimateGrowth;
  return static_cast<double>(size) >= growth * static_cast<double>(handed) ||
         (record_.full() && (size > handed || owed));
}

// The stretch as it stands; it has readings.
TransientJob TransientWatch::job() const {
  TransientJob job;
  job.dwell = stretch_.dwell;
  job.stretch = stretch_.number;
  job.result.at_fault = at_fault_;
  job.readings = record_.readings();
  job.result.from_s = to_s(job.readings.front().t_ns);
  job.result.until_s = to_s(job.readings.back().t_ns);
  job.result.given = job.readings.size();
  job.result.last = last_;
  return job;
}

TransientJob TransientWatch::hand_over() {
  out_ = true;
  if (last_job_) {
    TransientJob last = std::move(*last_job_);
    of_last_ = std::stop_source();
    last.stop = of_last_.get_token();
    last_job_.reset();
    return last;
  }
  TransientJob next = job();
  next.result.may_search = stretch_.anew != AnewSearch::not_asked || record_.full();
  stretch_.handed = next.result.given;
  stale_ = std::stop_source();
  next.stop = stale_.get_token();
  return next;
}

std::shared_ptr<const TransientEstimate> TransientWatch::take_back(TransientJob job) {
  out_ = false;
  const bool last = job.ended != nullptr;
  if (!last && (phase_ == Phase::waiting || job.stretch != stretch_.number)) return nullptr;
  auto estimate = std::make_shared<const TransientEstimate>(std::move(job.result));
  if (!last) {
    newest_ = estimate;
    stretch_.anew = estimate->estimate.anew;
  }
  return estimate;
}

}  // namespace dwell
