// Hands the stream to the recorder, and at certain positions of it the dwells.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "daemon/estimate/run_pipeline.hpp"
#include "daemon/record/stream_sink.hpp"

namespace dwell {

// Bound to the estimation thread.
class RunTap {
 public:
  // sink: may be null; then nothing is handed on. every_s: stream time between two looks at a dwell.
  RunTap(record::StreamSink* sink, double every_s) : sink_(sink), every_ns_(static_cast<std::int64_t>(every_s * 1e9)) {}

  // A record, before anything that the pipelines make of it.
  void record(const Record& record) noexcept {
    if (sink_ != nullptr) sink_->record(record);
  }
  // A run begins with this record: the first look is due once `every_s` has passed.
  void begin(std::int64_t t_ns) noexcept { next_ns_ = t_ns + every_ns_; }
  // How many of these records to take before look() is called: up to the one at which a look is due, or all.
  [[nodiscard]] std::size_t until_look(std::span<const Record> records) const noexcept {
    if (sink_ == nullptr) return records.size();
    const auto due = [this](const Record& record) { return record.t_ns >= next_ns_; };
    const auto at = std::find_if(records.begin(), records.end(), due);
    return static_cast<std::size_t>(at - records.begin()) + (at != records.end() ? 1 : 0);
  }
  // The run's pipeline has taken the record of t_ns. While it is busy with a long piece of work, the look waits.
  void look(RunPipeline& run, std::int64_t t_ns) {
    if (sink_ == nullptr || t_ns < next_ns_ || run.measurement().busy()) return;
    next_ns_ = std::max(next_ns_ + every_ns_, t_ns);
    sink_->result(run.position(), false, std::make_shared<const Dwell>(run.measurement().current()));
  }
  // An estimate or a verification was published after the record taken last.
  void model(const RunPipeline& run, record::ModelResult result) {
    if (sink_ != nullptr) sink_->model(run.position(), std::move(result));
  }
  // A dwell of the run has ended with that record.
  void ended(std::uint64_t position, std::shared_ptr<const Dwell> dwell) {
    if (sink_ != nullptr) sink_->result(position, true, std::move(dwell));
  }
  // The shown state has changed, whether a run goes on or not.
  void state(const record::StateChange& change, std::shared_ptr<const Dwell> after) {
    if (sink_ != nullptr) sink_->state(change, std::move(after));
  }

 private:
  record::StreamSink* sink_;
  std::int64_t every_ns_;
  std::int64_t next_ns_ = 0;
};

}  // namespace dwell
