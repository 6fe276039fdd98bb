// Sums the moments of all channels over any stretch of a dwell, at one (ω, t_ref).
#pragma once

#include <cstdint>
#include <vector>

#include "core/fit/moments.hpp"

namespace dwell {

// All that a fit needs of one channel. `readings`: moments of s - reference.
struct ChannelMoments {
  const double* instants = nullptr;  // 2H+1 angles; M_0^0, the first, is the number of samples
  const double* readings = nullptr;  // H+1 angles
};

// Blocks fills it, block by block. The constructor allocates all memory.
class Totals {
 public:
  Totals(int channels, int harmonics);

  // Empties the sums. Sets added from now on are turned to omega (rad/s) and t_ref.
  void restart(double omega, std::int64_t t_ref_ns) noexcept;
  // The same for one channel, which gets instants of its own. The other channels keep their sums.
  void restart_channel(int c, double omega, std::int64_t t_ref_ns) noexcept;
  // The turn of sets from (omega, centre) to this (ω, t_ref). faster (rad/s), ahead (rad): by how much a drifting drive
  // was there beyond ω and its phase.
  [[nodiscard]] moments::Turn turn_from(double omega, std::int64_t centre_ns, double faster = 0.0,
                                        double ahead = 0.0) const noexcept;
  // Declares that the sets to be added to c next share the instants of `owner`. If c shared another channel's before, c
  // gets a copy of these as its own. Call it for every channel before add() is called for any.
  void share(int c, int owner) noexcept;
  // Adds sets, turned; the instants only if c has its own.
  void add(int c, const ChannelMoments& sets, const moments::Turn& turn) noexcept;

  // Writes the same sums at another (ω', t_ref) to `out`, an object of the same size. Valid while |ω' - ω| times half
  // the stretch is well below 1. O(channels · H).
  void turned(double omega, std::int64_t t_ref_ns, Totals& out) const noexcept;

  [[nodiscard]] ChannelMoments channel(int c) const noexcept;
  // H of its sets.
  [[nodiscard]] int harmonics() const noexcept { return readings_count_ - 1; }
  [[nodiscard]] double omega() const noexcept { return omega_; }
  [[nodiscard]] std::int64_t t_ref_ns() const noexcept { return t_ref_ns_; }
  // Mean instant of a channel's samples, ns; t_ref if there are none.
  [[nodiscard]] std::int64_t centroid_ns(int c) const noexcept;

 private:
  [[nodiscard]] double* instants(int c) noexcept;
  [[nodiscard]] double* readings(int c) noexcept;

  int channels_, instants_count_, readings_count_;
  double omega_ = 0.0;
  std::int64_t t_ref_ns_ = 0;
  std::vector<double> instants_, readings_;
  // Channel whose instants each channel shares. Itself: its own; -1: nothing added yet. An owner is its own owner.
  std::vector<int> owner_;
};

}  // namespace dwell
