// What the estimation thread hands to the recorder: the ordered stream, and the published dwells with their positions.
//
// Brackets of a run. Three records of Kind::run mark it, each with a RunEdge:
//   armed   a pipeline starts here. While no run goes on, two pipelines take the stream; the younger started one span
//           (RunCycle::span_ns, at least 10 s) after the elder. After each span the elder is replaced
//   begins  the elder has recognized the drive: the run begins. It reaches back to the elder's
//           `armed`. Record::value says how many records earlier that is; the recorder keeps all records since then
//   ends    the last record of the run
// The stream of a run file begins with `armed` of its pipeline and ends with `ends`. Further `armed` records, of the
// younger pipeline, may lie in between.
//
// Position. The record RunEdge::armed of the run's pipeline is position 1, each further record one more.
//
// Replay. A new Measurement (daemon/estimate/measurement.hpp) is given every record of the run by take(), the Kind::run
// ones included, and finish() after RunEdge::ends. Then
// - a final result at `position` is the dwell of an event dwell_finished during take() of that record, or, at the
//   position of RunEdge::ends, during its take() or finish();
// - any other result is current() after take() of that record.
// Recording and replay give the same bits. At the position of a result neither pipeline is in a long piece of work.
// Several results may have one position; they come in their order.
#pragma once

#include <cstdint>
#include <memory>
#include <variant>

#include "core/result/dwell.hpp"
#include "core/stream/record.hpp"

namespace dwell {
struct TransientEstimate;
struct VerifiedDwell;
}  // namespace dwell

namespace dwell::record {

// What the thread for long work computes: coefficients by any motion, or a verification. Both say which readings
// they were computed from. Never null.
using ModelResult = std::variant<std::shared_ptr<const TransientEstimate>, std::shared_ptr<const VerifiedDwell>>;

// On its way to the recorder, beside the dwell as it stands after the change.
struct StateChange {
  std::int64_t t_ns = 0;  // of the record after which it came
  State before = State::idle;
};

// Called on the estimation thread alone.
class StreamSink {
 public:
  virtual ~StreamSink() = default;
  // The next record of the stream, RunEdge records among them, before the pipeline takes it. Real-time safe: never
  // waits, never allocates.
  virtual void record(const Record& record) noexcept = 0;
  // A dwell of the current run, as it was right after record `position`. final: it ended there. After
  // RunEdge::begins first come the dwells that ended earlier in the run's records, each at its own position. From
  // RunEdge::ends to the next RunEdge::begins only finals come, of the run that has just ended and at the position of
  // its end. Never waits.
  virtual void result(std::uint64_t position, bool final, std::shared_ptr<const Dwell> dwell) = 0;
  // Published after record `position` of the current run. That position depends on the processor's time, so a replay
  // compares the result alone. Never waits.
  virtual void model(std::uint64_t position, ModelResult result) = 0;
  // The state has changed after the record handed over last; a run may reach back to it. after: never null. Never
  // waits.
  virtual void state(const StateChange& change, std::shared_ptr<const Dwell> after) = 0;
};

}  // namespace dwell::record
