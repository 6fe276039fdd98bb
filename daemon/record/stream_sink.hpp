// What the estimation thread hands to whoever records: the ordered stream, and what was published at which position.
//
// Positions. A run that the drive begins also holds the time before it. So pipelines are born ahead of runs, each at a
// record of Kind::run that says RunEdge::armed. While no run goes on, two of them live, the elder at least 10 s old.
// Every 10 s the elder is given up and a new one is born. Once the elder sees the drive, a record says
// RunEdge::begins: the run reaches back to the birth of that pipeline. The stream of a run file so begins with the
// record RunEdge::armed of its pipeline (position 1) and ends with RunEdge::ends. A replay hands the same records to a
// new pipeline and gets the same bits.
#pragma once

#include <cstdint>
#include <memory>

#include "core/result/dwell.hpp"
#include "core/stream/record.hpp"

namespace dwell::record {

class StreamSink {
 public:
  virtual ~StreamSink() = default;
  // The next record of the stream, RunEdge records among them. Real-time safe: never waits, never allocates.
  virtual void record(const Record& record) noexcept = 0;
  // A dwell as it stood right after record `position` of the run (counted from RunEdge::armed, which is 1). final: it
  // has ended there. Never waits.
  virtual void result(std::uint64_t position, bool final, std::shared_ptr<const Dwell> dwell) = 0;
};

}  // namespace dwell::record
