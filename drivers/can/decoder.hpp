// From frames to the channels' numbers: which identifiers are wanted, and what each wanted frame holds. Pure; built
// once, then nothing allocates.
//
// A frame may be anything: identifiers, lengths and multiplexers of whatever value end in a verdict, never in a number
// that the frame does not hold.
#pragma once

#include <linux/can.h>

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "drivers/can/field.hpp"

namespace dwell::can {

// Which frames hold a signal. A J1939 parameter group is matched whatever the priority, the source (unless one is
// asked for) and, of a group that is sent to a destination, whatever that.
struct Match {
  canid_t id = 0;
  bool extended = false;
  bool j1939 = false;  // `id`: any identifier of the group
  int source = -1;     // j1939: the source address, or any
  bool operator==(const Match&) const = default;
};

// The kernel's filter for it.
[[nodiscard]] can_filter filter_of(const Match& match) noexcept;

// The multiplexor must have a value within one of the ranges.
struct Condition {
  Field selector;
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
};

struct Wanted {
  Match match;
  Field field;
  double factor = 1.0, offset = 0.0;
  std::vector<Condition> conditions;  // all of them
};

enum class Verdict : std::uint8_t {
  value,
  absent,       // multiplexed out
  short_frame,  // the frame ends before the signal
  invalid       // not a finite number, or by J1939 an error or "not available"
};

struct Reading {
  std::size_t wanted = 0;  // index into what the decoder was made from
  Verdict verdict = Verdict::absent;
  double value = 0.0;
};

class Decoder {
 public:
  explicit Decoder(std::vector<Wanted> wanted);

  // What a data frame holds of what is wanted; empty: nothing. Valid until the next call. `frame.len` bytes are valid;
  // a length beyond 64 is taken as 64.
  [[nodiscard]] std::span<const Reading> decode(const canfd_frame& frame) noexcept;

  // The filters that pass all that is wanted, each once.
  [[nodiscard]] std::vector<can_filter> filters() const;
  [[nodiscard]] const Wanted& wanted(std::size_t index) const noexcept { return wanted_[index]; }

 private:
  struct Key {
    canid_t id, mask;
    std::size_t first, count;  // of order_
  };
  [[nodiscard]] Reading read(std::size_t index, const std::uint8_t* data, std::size_t size) const noexcept;

  std::vector<Wanted> wanted_;
  std::vector<std::size_t> order_;  // indices into wanted_, those of one filter together
  // Ordered by id; of one mask each, since a frame must be looked up once for every mask there is.
  std::vector<std::vector<Key>> keys_;
  std::vector<Reading> readings_;
};

// The parameter group of a 29-bit identifier, without its destination.
[[nodiscard]] constexpr std::uint32_t group_of(canid_t id) noexcept {
  const std::uint32_t group = id >> 8U & 0x3FFFFU;
  return (group & 0xFF00U) < 0xF000U ? group & 0x3FF00U : group;
}

}  // namespace dwell::can
