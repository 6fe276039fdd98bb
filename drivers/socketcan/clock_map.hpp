// Brings the kernel's stamps of frames (CLOCK_REALTIME) onto CLOCK_MONOTONIC_RAW so that neither a step nor a slew of
// the wall clock moves a sample. Pure: the caller reads the clocks.
//
// Both clocks are read as a bracketed pair at every read of the socket, so that what lies between two pairs is short. A
// stamp is interpolated between the pair of the last read that found nothing more waiting, before which no frame that
// comes now can have come, and the pair of this read: exact under any constant slew. If the wall clock moved between
// the two by more than a slew explains, it was set. A stamp then was taken either before or after that: of the two
// instants that it may mean, the one within the two reads is right. When both are (a step smaller than the time
// between reads) their middle is taken, half their distance is what is not known, and the stamp counts as replaced.
// A stamp that means no instant between the reads is replaced by the instant of reading.
#pragma once

#include <cstdint>

namespace dwell::socketcan {

// Between a stamp and the frame's place in the socket's queue lies the kernel's soft interrupt: at most so long.
inline constexpr std::int64_t kQueueing_ns = 5'000'000;

// CLOCK_REALTIME between two readings of CLOCK_MONOTONIC_RAW.
struct ClockPair {
  std::int64_t raw_ns = 0;    // the middle of the two
  std::int64_t real_ns = 0;   // what the wall clock showed meanwhile
  std::int64_t width_ns = 0;  // between the two
};

// The narrowest of a few pairs; one alone when nothing interrupts it, some 100 ns.
[[nodiscard]] ClockPair read_clocks() noexcept;

struct Stamp {
  std::int64_t t_ns = 0;  // CLOCK_MONOTONIC_RAW
  std::uint32_t t_half_ns = 0;
  bool replaced = false;
};

class ClockMap {
 public:
  // `now`: nothing was waiting then.
  explicit ClockMap(const ClockPair& now) noexcept : empty_(now), now_(now) {}

  // The clocks after a read, before its stamps are mapped.
  void read_at(const ClockPair& now) noexcept { now_ = now; }
  // Everything that had come before `then` has been read and mapped.
  void empty_at(const ClockPair& then) noexcept { empty_ = then; }

  // A stamp of a frame read just now; 0: it has none.
  [[nodiscard]] Stamp map(std::int64_t real_ns) const noexcept;
  // For a frame whose stamp is of no use.
  [[nodiscard]] Stamp replacement() const noexcept;
  // Can a frame read just now have come at this instant?
  [[nodiscard]] bool plausible(std::int64_t t_ns) const noexcept;

 private:
  ClockPair empty_;
  ClockPair now_;
};

}  // namespace dwell::socketcan
