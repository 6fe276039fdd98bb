// A run's stream through a new pipeline, as when it was recorded (daemon/record/stream_sink.hpp, "Replay").
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/dwell/paced_pipeline.hpp"
#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"

namespace dwell::ctl {

// Bound to one thread. The pipeline's memory and cost.
class Replay {
 public:
  // The rig must be valid.
  explicit Replay(const Rig& rig) : pipeline_(rig) {}

  // Hands in the next record of the run, whatever its kind; Record::channel as the rig counts.
  void take(const Record& record);
  // The end of a stream that breaks off without RunEdge::ends: ends the dwell that is on. Nothing may be taken after.
  void break_off();
  // Of the record taken last; 0: none was.
  [[nodiscard]] std::uint64_t position() const noexcept { return position_; }

  // The dwells that have ended with the record taken last, in order. At RunEdge::ends the run is finished, and so are
  // the dwells in it.
  [[nodiscard]] const std::vector<Dwell>& ended() const noexcept { return ended_; }
  // Whether the state (idle, settling, measuring) has changed with it.
  [[nodiscard]] bool state_changed() const noexcept { return state_changed_; }
  // The dwell as it stands; nullopt: the pipeline is in a long piece of work, and nothing is published here. Allocates.
  [[nodiscard]] std::optional<Dwell> current() const;

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
