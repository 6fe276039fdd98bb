// Keeps the sync pulses of a drive as moments of runs of consecutive pulses, and fits a line through any stretch.
//
// Older runs are longer, so a fixed number of runs holds any train. The line t_k = t_0 + k T gives T. Its uncertainty
// comes from the residuals of single pulses, or from those of the means of runs if these are larger than independent
// jitter explains.
// Bound to one thread; real-time safe except for the constructor.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace dwell {

// What a stretch of pulses tells of the drive.
struct PulseLine {
  double omega = 0.0;         // rad/s
  double u = 0.0;             // its standard uncertainty, rad/s
  std::int64_t pulse_ns = 0;  // an instant of phase zero, on the line
  double span_s = 0.0;        // from the first pulse to the last

  // The instant of phase zero nearest to t.
  [[nodiscard]] std::int64_t nearest_ns(std::int64_t t_ns) const noexcept;
};

// A train: pulses with one numbering k. x = t - begin_ns - k · T_s is a pulse's residual, T_s the first guess of T.
struct PulseTrain {
  std::uint64_t number = 0;  // 0: none
  std::int64_t begin_ns = 0;
  double T_s = 0.0;
};

class PulseRuns {
 public:
  static constexpr int kFewest = 6;  // fewest pulses for a line

  PulseRuns();

  // Adds pulse k of a train at t; k grows within a train. With kRuns in use, the oldest quarter is dropped.
  void keep(const PulseTrain& train, std::int64_t t_ns, std::int64_t k) noexcept;
  // The line through the pulses of [from, to], by the train with most of them. Only runs that lie within count. None if
  // they have fewer than kFewest pulses. O(runs).
  [[nodiscard]] std::optional<PulseLine> over(std::int64_t from_ns, std::int64_t to_ns) const noexcept;

 private:
  static constexpr std::size_t kRuns = 512;
  static constexpr std::size_t kPerLength = 16;  // runs of one length; beyond it the oldest two are joined

  // Consecutive pulses of one train: their number, means of k and x (s), sums of squares and products about the means.
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
