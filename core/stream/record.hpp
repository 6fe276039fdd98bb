// Record is the element of the one ordered stream: the pipeline learns everything from records, and nothing else.
//
// Records are totally ordered by (t_ns, source, arrival within the source). The merger establishes that order, the
// pipeline consumes the records, a recorder can store them. They are the pipeline's only clock.
#pragma once

#include <cstdint>
#include <type_traits>

namespace dwell {

// What a record tells. t_ns is always its instant. `channel` is an index into Rig::channels unless the kind says
// otherwise. A kind names the fields that it uses; all others are zero.
enum class Kind : std::uint8_t {
  // `channel`; `value`: the device's own number, before scale and offset; `t_half_ns`; `stamped_ns`; `flags`: kGap,
  // kStampReplaced
  sample,
  channel_state,  // `channel`; `flags`: a Fault; Fault::none: the channel delivers again
  edge,           // a GPIO edge; `channel`: a Line; `value`: the level after it, 0 or 1; `flags`: kGap, kStampReplaced
  action,         // an operator's action; `flags`: an Action; `channel`: the request's number, 0: it has none
  tick,           // time goes on, nothing else
  run,            // a run begins or ends, or may begin here; `flags`: a RunEdge, which says what `value` and
                  // `channel` are
  loss,   // samples of `channel` that are not in the stream; `flags`: a Loss; `value`: how many since the last such
          // record
  fault,  // `channel`: an index into Rig::devices; `flags`: a Fault; `value`: how often since the last such record
};

// Whether the pipeline evaluates records of this kind. The other kinds are for recorders and readers of the stream.
[[nodiscard]] constexpr bool concerns_pipeline(Kind kind) noexcept {
  return kind != Kind::run && kind != Kind::loss && kind != Kind::fault;
}

// Sample and edge flags.
inline constexpr std::uint8_t kGap = 1;            // samples of this channel were lost immediately before this one
inline constexpr std::uint8_t kStampReplaced = 2;  // implausible stamp: t_ns is the host's instant

// The GPIO inputs. Level 1 is the active one, whatever the voltage.
enum class Line : std::uint16_t {
  interlock = 0,  // 1: the shaker may run. The first edge tells the level at the start
  sync = 1,       // an edge to 1 for each period of the excitation; edges to 0 make no record
};

// Why a channel does not deliver. The numbers equal DWELL_FAULT_... of dwell_driver.h. Recordings contain them.
enum class Fault : std::uint8_t {
  none = 0,
  disconnected = 1,     // no connection to the device
  timeout = 2,          // no answer within the time allowed
  exception = 3,        // the device refused the request
  bad_checksum = 4,     // a frame arrived damaged
  short_frame = 5,      // a frame arrived incomplete
  bad_frame = 6,        // a frame arrived that does not answer the request
  late_answer = 7,      // an answer to an earlier request
  invalid_value = 8,    // not a number, or outside the range of the type
  missed_deadline = 9,  // a poll would have begun too late and was skipped
  end_of_data = 10,     // a recording, or another finite source, has ended
  silent = 11,          // nothing arrived, and no fault is known
  overflow = 12,        // no room: in kernel or controller on the way in, or in the queue on the way out
  bus_error = 13,       // the bus controller reports errors on the line
  bus_off = 14,         // the bus controller left the bus because of too many errors
  untimely = 15,        // readings come too late for the stream's order, or stamped ahead of the clock
};
inline constexpr int kFaultCount = 16;

// Short name of a fault for people and for JSON, for instance "timeout".
[[nodiscard]] const char* to_string(Fault fault) noexcept;

enum class Action : std::uint8_t {
  rearm = 1,  // begin the dwell anew
};

// armed: a pipeline is born here. A run that begins later may reach back to it.
// begins: the run has begun. `value`: how many records before this one its pipeline's `armed` stands.
// ends: the run ends here, and so does its file. `value`: an EndOfRun.
// `channel` of begins and ends: the number of the operator's request; 0: no operator asked for it.
enum class RunEdge : std::uint8_t { begins = 1, ends = 2, armed = 3 };

// Why a run has ended.
enum class EndOfRun : std::uint8_t {
  drive_stopped = 1,  // the drive has been idle for long enough
  drive_unseen = 2,   // the drive could not be seen for several times as long
  by_operator = 3,    // an operator's stop, or start of another run
  service_stops = 4,
  restarted = 5,  // the recorder asked for a new run, since it had to stop recording this one
};

// Why a sample is not in the stream.
enum class Loss : std::uint8_t {
  refused = 1,   // the ring between its driver and the estimation was full
  late = 2,      // older than the newest record released
  ahead = 3,     // stamped ahead of the clock
  overflow = 4,  // the merger was full
};

// One element of the stream, 32 bytes, trivially copyable.
struct Record {
  std::int64_t t_ns = 0;        // ns, CLOCK_MONOTONIC_RAW (live) or the recording's own axis
  std::int64_t stamped_ns = 0;  // of a sample: its driver's stamp. t_ns may be a recovered instant instead
  double value = 0.0;           // see Kind
  std::uint32_t t_half_ns = 0;  // ns, half width of the rectangular uncertainty of t_ns
  std::uint16_t channel = 0;    // index into Rig::channels
  Kind kind = Kind::sample;
  std::uint8_t flags = 0;
};
static_assert(sizeof(Record) == 32 && std::is_trivially_copyable_v<Record>);

// Whether the record is this edge of a run.
[[nodiscard]] constexpr bool is_edge(const Record& record, RunEdge edge) noexcept {
  return record.kind == Kind::run && record.flags == static_cast<std::uint8_t>(edge);
}

}  // namespace dwell
