// The one ordered stream: everything the pipeline ever learns is a Record.
//
// Records are totally ordered by (t_ns, source, arrival within the source); the merger establishes that order, the
// pipeline consumes it, a recorder can store it behind the merger. Records are the pipeline's only clock.
#pragma once

#include <cstdint>
#include <type_traits>

namespace dwell {

// What a record tells. t_ns is always the instant. `channel` is an index into Rig::channels where nothing else is said.
// The fields of Record that a kind does not name are zero.
enum class Kind : std::uint8_t {
  // `channel`; `value`: the device's own number, before scale and offset; `t_half_ns`; `stamped_ns`; `flags`: kGap,
  // kStampReplaced
  sample,
  channel_state,  // `channel`; `flags`: a Fault; Fault::none says that the channel delivers again
  edge,           // a GPIO edge; `channel`: a Line; `value`: the level after it, 0 or 1; `flags`: kGap, kStampReplaced
  action,         // an operator's action; `flags`: an Action
  tick,           // time goes on, nothing else
  run,            // the first record of a run and the last; `flags`: a RunEdge
  loss,   // samples of `channel` that are not in the stream; `flags`: a Loss; `value`: how many since the last such
          // record
  fault,  // `channel`: an index into Rig::devices; `flags`: a Fault; `value`: how often since the last such record
};

// Whether the pipeline takes notice of records of that kind. The others are for whoever keeps the stream.
[[nodiscard]] constexpr bool concerns_pipeline(Kind kind) noexcept {
  return kind != Kind::run && kind != Kind::loss && kind != Kind::fault;
}

// Sample and edge flags.
inline constexpr std::uint8_t kGap = 1;            // samples of this channel were lost immediately before this one
inline constexpr std::uint8_t kStampReplaced = 2;  // the device's stamp was implausible; the instant is that of reading

// The GPIO inputs. Level 1 is the active one, whatever the voltage.
enum class Line : std::uint16_t {
  interlock = 0,  // 1: the shaker may run. The first edge is the level at the start; from 0 to 1: it may again
  sync = 1,       // one edge to 1 for each period of the excitation; edges to 0 are not told
};

// Why a channel does not deliver. The numbers are those of dwell_driver.h (DWELL_FAULT_...), and are recorded.
enum class Fault : std::uint8_t {
  none = 0,
  disconnected = 1,     // no connection to the device
  timeout = 2,          // no answer within the time allowed
  exception = 3,        // the device refused the request
  bad_checksum = 4,     // a frame arrived damaged
  short_frame = 5,      // a frame arrived incomplete
  bad_frame = 6,        // a frame arrived that does not answer what was asked
  late_answer = 7,      // an answer to an earlier request
  invalid_value = 8,    // not a number, or beyond what the type can carry
  missed_deadline = 9,  // a poll began too late and was skipped
  end_of_data = 10,     // a finite source has been played to its end
  silent = 11,          // nothing arrived although nothing failed
  overflow = 12,        // lost for lack of room: on the way in (kernel, controller), or waiting to be sent
  bus_error = 13,       // the bus controller reports errors on the line
  bus_off = 14,         // the bus controller has left the bus for too many of them
  untimely = 15,        // readings come that cannot be put in order: too late, or stamped ahead of the clock
};
inline constexpr int kFaultCount = 16;

// Short name of a fault as shown to people and in JSON, for instance "timeout".
[[nodiscard]] const char* to_string(Fault fault) noexcept;

enum class Action : std::uint8_t {
  rearm = 1,  // begin the dwell anew
};

enum class RunEdge : std::uint8_t { begins = 1, ends = 2 };

// Why a sample is not in the stream.
enum class Loss : std::uint8_t {
  refused = 1,   // the ring between its driver and the estimation was full
  late = 2,      // older than what had been released
  ahead = 3,     // stamped ahead of the clock
  overflow = 4,  // the merger was full
};

// One element of the stream, 32 bytes, trivially copyable.
struct Record {
  std::int64_t t_ns = 0;        // ns, CLOCK_MONOTONIC_RAW (live) or the recording's own axis
  std::int64_t stamped_ns = 0;  // of a sample: its driver's stamp; t_ns may be recovered from many of these
  double value = 0.0;           // see Kind
  std::uint32_t t_half_ns = 0;  // ns, half width of what is known of the instant (rectangular)
  std::uint16_t channel = 0;    // index into Rig::channels
  Kind kind = Kind::sample;
  std::uint8_t flags = 0;
};
static_assert(sizeof(Record) == 32 && std::is_trivially_copyable_v<Record>);

}  // namespace dwell
