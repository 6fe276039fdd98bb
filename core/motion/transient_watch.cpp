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
constexpr double kBefore = 1.5;
// … and after its beginning, before the first estimate: with fewer most rigs' coefficients are not determined.
constexpr double kFirst = 2.0;
// From one estimate to the next the readings grow by this factor. All together they cost 1/(1 - 1/1.5) = 3 times the
// last. Closer to 1: newer numbers, and more work; 2: twice the last, and numbers up to half the stretch old.
constexpr double kGrowth = 1.5;
// If a hold of so many periods ends while the dwell settles, the drive has changed, and another stretch begins. A ramp
// leaves a hold every period. Longer: an operator's change of the drive goes unnoticed. Shorter: a slow ramp is torn.
constexpr double kSteady = 8.0;

std::size_t most_readings(const Rig& rig) {
  return std::max<std::size_t>(1, MotionOptions{}.most_work / static_cast<std::size_t>(MotionModel(rig, {}).states()));
}

}  // namespace

void TransientJob::run(const Rig& rig) {
  MotionRecorder recorder(rig);
  for (const HoldRecord::Reading& reading : readings)
    recorder.take(
        {.t_ns = reading.t_ns, .value = reading.value, .channel = static_cast<std::uint16_t>(reading.channel)});
  result.estimate = estimate_motion(rig, recorder.data());
}

TransientWatch::TransientWatch(const Rig& rig)
    : period_s_(1.0 / rig.excitation.frequency_hz), record_(most_readings(rig)) {
  for (const Channel& channel : rig.channels) counts_.push_back(channel.measures != Quantity::auxiliary);
}

void TransientWatch::take(const Record& record, std::int64_t t_ns, std::uint64_t position) noexcept {
  if (record.kind != Kind::sample || record.channel >= counts_.size() || !counts_[record.channel]) return;
  if (record_.push({t_ns, record.value, record.channel})) last_ = position;
  now_s_ = to_s(t_ns);
}

void TransientWatch::follow(const Dwell& now) {
  const bool on = now.index && (now.state == State::settling || now.state == State::measuring);
  if (!on || !std::isfinite(now.start_s)) return wait();
  const bool other_drive = now.start_s - hold_s_ >= kSteady * period_s_;
  if (now.index != dwell_ || other_drive) begin(now);
  hold_s_ = now.start_s;
  if (std::isfinite(now.settled_s)) {
    if (phase_ != Phase::taken_over) record_.roll();
    phase_ = Phase::taken_over;
  } else if (phase_ == Phase::taken_over && record_.resume()) {
    phase_ = out_ ? Phase::estimating : Phase::gathering;
  }
}

void TransientWatch::wait() {
  if (phase_ == Phase::waiting) return;
  phase_ = Phase::waiting;
  record_.roll();
  dwell_.reset();
  newest_.reset();
}

void TransientWatch::begin(const Dwell& now) {
  if (now.index != dwell_) newest_.reset();
  dwell_ = now.index;
  start_s_ = now.start_s;
  record_.begin(to_ns(start_s_ - kBefore * period_s_));
  ++stretch_;
  handed_ = 0;
  phase_ = Phase::gathering;
}

bool TransientWatch::due() const noexcept {
  if (phase_ != Phase::gathering || out_) return false;
  const std::size_t size = record_.size();
  if (handed_ == 0) return size > 0 && (record_.full() || now_s_ - start_s_ >= kFirst * period_s_);
  return static_cast<double>(size) >= kGrowth * static_cast<double>(handed_) || (record_.full() && size > handed_);
}

TransientJob TransientWatch::hand_over() {
  TransientJob job;
  job.stretch = stretch_;
  job.readings = record_.readings();
  job.result.from_s = to_s(job.readings.front().t_ns);
  job.result.until_s = to_s(job.readings.back().t_ns);
  job.result.given = handed_ = job.readings.size();
  job.result.last = last_;
  out_ = true;
  phase_ = Phase::estimating;
  return job;
}

void TransientWatch::take_back(TransientJob job) {
  out_ = false;
  if (phase_ == Phase::estimating) phase_ = Phase::gathering;
  if (phase_ != Phase::waiting && job.stretch == stretch_)
    newest_ = std::make_shared<const TransientEstimate>(std::move(job.result));
}

}  // namespace dwell
