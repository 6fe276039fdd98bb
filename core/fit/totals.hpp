// The moments of all channels over any stretch of a dwell, at one (ω, t_ref).
#pragma once

#include <cstdint>
#include <vector>

#include "core/fit/moments.hpp"

namespace dwell {

// All that a fit needs of one channel. `readings` are of s - reference.
struct ChannelMoments {
  const double* instants = nullptr;  // 2H+1 angles; M_0^0, the first, is the number of samples
  const double* readings = nullptr;  // H+1 angles
};

// Filled block by block by Blocks; sized once, no allocation later.
class Totals {
 public:
  Totals(int channels, int harmonics);

  // Empties it; what is added from now on is brought to omega (rad/s) and t_ref.
  void restart(double omega, std::int64_t t_ref_ns) noexcept;
  // The same of one channel alone, its instants its own; the others are left as they are.
  void restart_channel(int c, double omega, std::int64_t t_ref_ns) noexcept;
  // How sets about centre at omega come to (ω, t_ref), of a drive that was there `faster` (rad/s) and `ahead` (rad) of
  // this ω.
  [[nodiscard]] moments::Turn turn_from(double omega, std::int64_t centre_ns, double faster = 0.0,
                                        double ahead = 0.0) const noexcept;
  // What is added to a channel next shares the instants of `owner`: makes room for c's own where it can no longer share
  // all of them. For every channel, before any is added to.
  void share(int c, int owner) noexcept;
  // Adds sets that were taken elsewhere; the instants only where c has its own.
  void add(int c, const ChannelMoments& sets, const moments::Turn& turn) noexcept;

  // The same sums at another (ω, t_ref), into `out` of the same size. Good while |ω' - ω| times half the stretch is
  // well below 1. O(channels · H).
  void turned(double omega, std::int64_t t_ref_ns, Totals& out) const noexcept;

  [[nodiscard]] ChannelMoments channel(int c) const noexcept;
  // H of the sets that it holds.
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
  // Whose instants a channel shares, itself: its own; -1: nothing added yet. An owner owns its own.
  std::vector<int> owner_;
};

}  // namespace dwell
