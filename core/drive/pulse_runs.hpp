// The sync pulses of a drive, kept as moments of runs of neighbours, and the straight line through any stretch of them.
//
// The older the pulses, the longer their runs: a fixed number of runs holds any train. With t_k = t_0 + k T the line
// gives T and its uncertainty from the residuals about it: those of single pulses, or those of the means of their runs
// where these lie further off than independent jitter explains.
// Bound to one thread; real-time safe but for the constructor.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace dwell {

// What a stretch of pulses says of the drive.
struct PulseLine {
  double omega = 0.0;         // rad/s
  double u = 0.0;             // its standard uncertainty, rad/s; NaN: too few pulses to tell
  std::int64_t pulse_ns = 0;  // an instant of phase zero, as the line has it
  double span_s = 0.0;        // from the first pulse to the last

  // The instant of phase zero nearest to t.
  [[nodiscard]] std::int64_t nearest_ns(std::int64_t t_ns) const noexcept;
};

// Pulses whose numbers k belong together. x = t - begin_ns - k · T_s is what lies beyond its first guess.
struct PulseTrain {
  std::uint64_t number = 0;  // 0: none
  std::int64_t begin_ns = 0;
  double T_s = 0.0;
};

class PulseRuns {
 public:
  static constexpr int kFewest = 6;  // pulses of a line

  PulseRuns();

  // Pulse k of a train at t; k grows within a train. No allocation.
  void keep(const PulseTrain& train, std::int64_t t_ns, std::int64_t k) noexcept;
  // The line through the pulses of [from, to], by the train that has most of them there; none with fewer than
  // kFewest. O(runs).
  [[nodiscard]] std::optional<PulseLine> over(std::int64_t from_ns, std::int64_t to_ns) const noexcept;

 private:
  static constexpr std::size_t kRuns = 512;
  static constexpr std::size_t kPerLength = 16;  // runs of one length kept before two of them are joined

  // Pulses of one train one after the other: count, means of k and x, sums of squares and products about these (x in
  // s).
  struct Run {
    PulseTrain train;
    std::int64_t first_ns, last_ns;
    double n, k, x, kk, kx, xx;
  };

  static void join(Run& into, const Run& other) noexcept;
  template <class Take>
  void each_run(std::int64_t from_ns, std::int64_t to_ns, Take&& take) const noexcept;

  std::vector<Run> runs_;  // oldest first
};

}  // namespace dwell
