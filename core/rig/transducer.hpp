// A transducer's own frequency response: what is divided out of a channel's phasors.
//
// A reading is the motion's q-th derivative (q = 0 displacement and force, 1 velocity, 2 acceleration), delayed, and
// filtered. With y = Im(Y exp(jωt)) the channel's phasor is X = Y (jω)^q H(jω), H = exp(-jωτ) H_low H_high.
//
// Filters have unit gain in the pass band. butterworth and bessel: the corner is where the magnitude is 1/√2. rc:
// `order` equal first-order stages, each with that corner. A high-pass is the low-pass with s -> 1/s about the corner.
#pragma once

#include <complex>
#include <cstddef>

#include "core/rig/rig.hpp"

namespace dwell {

// An absolute transducer on the table: what it sees is imposed. Thread-safe.
[[nodiscard]] inline bool shows_drive(const Channel& channel) noexcept {
  return channel.measures != Quantity::force && channel.measures != Quantity::auxiliary && channel.at == 0 &&
         !channel.relative_to;
}

// H of a low-pass (high = false) or high-pass at f_hz; 1 for FilterKind::none. Thread-safe, O(order).
[[nodiscard]] std::complex<double> filter_response(const Filter& filter, bool high, double f_hz) noexcept;
// The same for a motion exp(st), s in rad/s: of a decaying oscillation too.
[[nodiscard]] std::complex<double> filter_response(const Filter& filter, bool high, std::complex<double> s) noexcept;

// Powers of jω by which a quantity differs from the displacement: 0, 1 or 2 (force: 0).
[[nodiscard]] int derivative_order(Quantity quantity) noexcept;

// H(jω) of a channel at f_hz: delay (its own and `device_delay_s`) and filters, without the derivative.
[[nodiscard]] std::complex<double> response(const Channel& channel, double device_delay_s, double f_hz) noexcept;
// H(s) for a motion exp(st), s in rad/s.
[[nodiscard]] std::complex<double> response(const Channel& channel, double device_delay_s,
                                            std::complex<double> s) noexcept;

// d ln H / d x for x the frequency (1/Hz), the low-pass corner, the high-pass corner (1/Hz each).
struct LogSlopes {
  std::complex<double> frequency, lowpass_corner, highpass_corner;
};
[[nodiscard]] LogSlopes response_slopes(const Channel& channel, double device_delay_s, double f_hz) noexcept;

// Delay of the device that a channel is read from, s; 0 where it has none.
[[nodiscard]] inline double device_delay_s(const Rig& rig, const Channel& channel) noexcept {
  return channel.device >= 0 ? rig.devices[static_cast<std::size_t>(channel.device)].delay_s : 0.0;
}

}  // namespace dwell
