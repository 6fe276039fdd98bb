// The steady part of a dwell's readings: mean and fundamental, as fitted, seen through each channel's transducer.
// Readings less this leave the transient, the harmonics and the noise.
//
//   steady(t) = mean + Im(Y H(jω) exp(jω (t - t_ref)))    Y: the channel's phasor, H: its transducer's response
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

class SteadyPart {
 public:
  // nullopt: the dwell has not settled. origin_ns: t = 0 of the dwell's axis, on the stream's clock.
  [[nodiscard]] static std::optional<SteadyPart> of(const Dwell& dwell, const Rig& rig, std::int64_t origin_ns);

  // At an instant of the stream's clock, from_ns() to to_ns(), in the channel's own unit; NaN: its phasor is not valid.
  [[nodiscard]] double at(std::size_t channel, std::int64_t t_ns) const noexcept;
  [[nodiscard]] std::int64_t from_ns() const noexcept { return from_ns_; }
  [[nodiscard]] std::int64_t to_ns() const noexcept { return to_ns_; }
  [[nodiscard]] int dwell() const noexcept { return dwell_; }
  // Instant from which on readings were used for the fit: when the dwell had settled.
  [[nodiscard]] std::int64_t fitted_from_ns() const noexcept { return fitted_from_ns_; }

 private:
  struct Wave {
    double mean, amplitude, phase_rad;
  };
  int dwell_ = 0;
  double omega_ = 0.0;
  std::int64_t ref_ns_ = 0, from_ns_ = 0, to_ns_ = 0, fitted_from_ns_ = 0;
  std::vector<Wave> waves_;  // by Rig::channels
};

}  // namespace dwell
