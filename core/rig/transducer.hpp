// Frequency response of a transducer. A channel's phasor is divided by it to get the phasor of the motion.
//
// A reading is the q-th derivative of the motion (q = 0 displacement and force, 1 velocity, 2 acceleration), delayed
// and filtered. With y = Im(Y exp(jωt)) the channel's phasor is X = Y (jω)^q H(jω), H = exp(-jωτ) H_low H_high.
//
// Filters have unit gain in the pass band. butterworth and bessel: the magnitude at the corner is 1/√2. rc: `order`
// equal first-order stages, each with that corner. A high-pass is the low-pass with s -> 1/s, s relative to the corner.
#pragma once

#include <complex>
#include <cstddef>

#include "core/rig/rig.hpp"

namespace dwell {

// Whether the channel is an absolute transducer on the table, which shows the imposed motion. Thread-safe.
[[nodiscard]] inline bool shows_drive(const Channel& channel) noexcept {
  return channel.measures != Quantity::force && channel.measures != Quantity::auxiliary && channel.at == 0 &&
         !channel.relative_to;
}

// H of a low-pass (high = false) or high-pass at f_hz; 1 for FilterKind::none. Thread-safe, O(order).
[[nodiscard]] std::complex<double> filter_response(const Filter& filter, bool high, double f_hz) noexcept;
// The same for a motion exp(st), s in rad/s, for instance a decaying oscillation.
[[nodiscard]] std::complex<double> filter_response(const Filter& filter, bool high, std::complex<double> s) noexcept;

// q of a quantity: 0, 1 or 2.
[[nodiscard]] int derivative_order(Quantity quantity) noexcept;

// H(jω) of a channel at f_hz: its own delay, `device_delay_s` and its filters, without the derivative (jω)^q.
[[nodiscard]] std::complex<double> response(const Channel& channel, double device_delay_s, double f_hz) noexcept;
// H(s) for a motion exp(st), s in rad/s.
[[nodiscard]] std::complex<double> response(const Channel& channel, double device_delay_s,
                                            std::complex<double> s) noexcept;

// Slopes d ln H / dx at f_hz, in 1/Hz, for x = frequency, low-pass corner, high-pass corner; 0 without such a filter.
struct LogSlopes {
  std::complex<double> frequency, lowpass_corner, highpass_corner;
};
[[nodiscard]] LogSlopes response_slopes(const Channel& channel, double device_delay_s, double f_hz) noexcept;

// Delay of the channel's device, s; 0 for a channel without a device.
[[nodiscard]] inline double device_delay_s(const Rig& rig, const Channel& channel) noexcept {
  return channel.device >= 0 ? rig.devices[static_cast<std::size_t>(channel.device)].delay_s : 0.0;
}

}  // namespace dwell
