// An operator's request to the service, for the record of who did what and why.
//
// A request enters the ordered stream as a record with the request's number in Record::channel: `start` as
// RunEdge::begins (and as RunEdge::ends of the run that it ends), `stop` as RunEdge::ends, `rearm` as Kind::action. The
// sink gets the request before that record, so it knows every number that comes. Requests are numbered in the order of
// the stream. `label` changes nothing that the pipeline sees, so it has no record and the number 0.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/record/run_entries.hpp"

namespace dwell::record {

struct Request {
  std::uint16_t number = 0;  // 1 … 65535, then 1 again; 0: names the run that goes on
  std::uint16_t after = 0;   // of label: the number of the newest request before it; 0: none
  std::string label;         // of start and label: the run's; empty: none
  StoredEvent event;         // its `what` is "action"; the sink fills in position and instant
};

// What keeps runs from being recorded.
struct Obstacle {
  std::string why;            // and what to do about it, for people; empty: nothing is in the way
  bool of_every_run = false;  // false: of the run that goes on alone; another would be recorded
};

class RequestSink {
 public:
  virtual ~RequestSink() = default;
  // Thread-safe; never waits. Called on the event loop, once for each request that enters the stream.
  virtual void request(Request request) = 0;
  // As of the last time it tried. While room is missing on the disk it tries several times a second. Thread-safe, short
  // lock.
  [[nodiscard]] virtual Obstacle obstacle() const = 0;
};

}  // namespace dwell::record
