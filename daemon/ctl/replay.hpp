// Takes a run's stream through a new pipeline, as during the recording (daemon/record/stream_sink.hpp, "Replay").
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/dwell/dwell_draft.hpp"
#include "core/dwell/paced_pipeline.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "core/stream/sample_history.hpp"

namespace dwell::ctl {

// Bound to one thread. The pipeline's memory and cost.
class Replay {
 public:
  // The rig must be valid.
  explicit Replay(const Rig& rig) : pipeline_(rig) {}

  // Takes the next record of the run, of any kind; Record::channel is an index into the rig's channels.
  void take(const Record& record) {
    ++position_;
    if (!ended_.empty()) ended_.clear();
    state_changed_ = false;
    if (const std::uint8_t change = pipeline_.push(record); change != kNothing) note(change);
    if (is_edge(record, RunEdge::ends)) finish();
  }
  // Takes the samples and ticks that `records` begins with, up to where a dwell may end or the state change. Returns
  // how many; 0: take() must take the next one. Costs less than take().
  std::size_t take_samples(std::span<const Record> records) {
    const std::size_t n = pipeline_.push_in_block(records);
    if (n == 0) return 0;
    position_ += n;
    if (!ended_.empty()) ended_.clear();
    state_changed_ = false;
    return n;
  }
  // Ends a stream that breaks off without RunEdge::ends: the current dwell ends. Nothing may be taken afterwards.
  void break_off();
  // Position of the record taken last; 0: none yet.
  [[nodiscard]] std::uint64_t position() const noexcept { return position_; }

  // The dwells that ended with the record taken last, in order. At RunEdge::ends the run's last dwell is among them.
  [[nodiscard]] const std::vector<Dwell>& ended() const noexcept { return ended_; }
  // Whether that record changed the state (idle, settling, measuring).
  [[nodiscard]] bool state_changed() const noexcept { return state_changed_; }
  // The current dwell; nullopt: the pipeline is in a long piece of work and publishes nothing here. Allocates.
  [[nodiscard]] std::optional<Dwell> current() const;
  // current(), its coefficients not computed yet: that may be done on another thread, as long as this lives.
  [[nodiscard]] std::optional<DwellDraft> draft() const;
  // The readings that the pipeline has used, as the service had them after the same record; null: the pipeline is in a
  // long piece of work.
  [[nodiscard]] const SampleHistory* readings() const noexcept {
    return pipeline_.busy() ? nullptr : &pipeline_.pipeline().readings();
  }

 private:
  void finish();
  void note(std::uint8_t change);

  PacedPipeline pipeline_;
  std::uint64_t position_ = 0;
  std::vector<Dwell> ended_;
  bool state_changed_ = false;
  bool finished_ = false;
};

}  // namespace dwell::ctl
