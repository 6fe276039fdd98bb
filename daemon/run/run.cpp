#include "daemon/run/run.hpp"

#include <utility>

#include "daemon/acquire/hold_back.hpp"
#include "daemon/clock.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/version.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kEstimateBound_ns = 2'000'000'000;

EstimatorOptions options_for(const config::RigFile& file, gpio::Link* edges, std::shared_ptr<LongWork> work,
                             record::StreamSink* sink, TraceFeed* traces) {
  EstimatorOptions options;
  options.hold_back_ns = hold_back_ns(file);
  options.gpio = edges;
  options.long_work = std::move(work);
  options.traces = traces;
  options.runs = {file.recording.on, sink, file.recording.every_s, true};
  return options;
}

}  // namespace

Run::Run(const config::RigFile& file, std::vector<DeviceFeed> devices, gpio::Link* edges, Log& log,
         std::function<void()> wake, record::StreamSink* sink, TraceFeed* traces)
    : bracketed_(file.recording.on),
      info_{file.sha256, kVersion, {}},
      long_work_(file.verification.live ? std::make_shared<LongWork>(file.rig, file.verification.accuracy) : nullptr),
      estimator_(file.rig, std::move(devices), options_for(file, edges, long_work_, sink, traces), log, std::move(wake),
                 raw_now_ns()) {}

void Run::start() {
  thread_.emplace(estimator_);
  if (long_work_) {
    motion_thread_.emplace(long_work_, LongWorkThread::Does::estimates);
    verify_thread_.emplace(long_work_, LongWorkThread::Does::verifications);
  }
}

void Run::end() {
  // First: what the end of the run brings about is not computed any more.
  motion_thread_.reset();
  verify_thread_.reset();
  thread_.reset();
}

bool Run::refresh() {
  const bool newer = estimator_.refresh();
  if (latest().start_utc_ns != start_utc_ns_) info_.start_utc = record::iso_utc(start_utc_ns_ = latest().start_utc_ns);
  return newer;
}

std::optional<WatchedThread> Run::thread() const {
  if (!thread_) return std::nullopt;
  return WatchedThread{"estimate", thread_->last_turn_ns(), kEstimateBound_ns};
}

}  // namespace dwell
