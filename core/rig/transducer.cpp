#include "core/rig/transducer.hpp"

#include <array>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/base/complex.hpp"

namespace dwell {
namespace {

// H(s) of a Butterworth low-pass with corner 1 rad/s, as a product over its poles.
Complex butterworth(int order, Complex s) noexcept {
  Complex product = 1.0;
  for (int k = 0; k < order; ++k) {
    const Complex pole = std::polar(1.0, std::numbers::pi / 2 + std::numbers::pi * (2 * k + 1) / (2.0 * order));
    product *= -pole / (s - pole);
  }
  return product;
}

// H(s) = θ_n(0) / θ_n(s) of a Bessel low-pass with unit delay. Recurrence of the reverse Bessel polynomials:
// θ_n = (2n-1) θ_{n-1} + s² θ_{n-2}.
Complex bessel_unit_delay(int order, Complex s) noexcept {
  Complex before = 1.0, now = s + 1.0;
  double now_0 = 1.0;  // θ_n(0)
  for (int n = 2; n <= order; ++n) {
    const Complex next = (2.0 * n - 1) * now + s * s * before;
    before = now;
    now = next;
    now_0 *= 2.0 * n - 1;
  }
  return now_0 / now;
}

// Angular frequency at which the unit-delay Bessel low-pass has magnitude 1/√2, by bisection (it falls monotonically).
double bessel_corner(int order) noexcept {
  double low = 0.0, high = 10.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (std::norm(bessel_unit_delay(order, {0.0, middle})) > 0.5 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace

Complex filter_response(const Filter& filter, bool high, double f_hz) noexcept {
  return filter_response(filter, high, Complex{0.0, kTwoPi * f_hz});
}

Complex filter_response(const Filter& filter, bool high, Complex s) noexcept {
  if (filter.kind == FilterKind::none) return 1.0;
  s /= kTwoPi * filter.hz;
  if (high) s = 1.0 / s;
  switch (filter.kind) {
    case FilterKind::none:
      return 1.0;
    case FilterKind::butterworth:
      return butterworth(filter.order, s);
    case FilterKind::bessel:
      return bessel_unit_delay(filter.order, s * bessel_corner(filter.order));
    case FilterKind::rc:
      return std::pow(1.0 / (1.0 + s), filter.order);
  }
  return 1.0;
}

int derivative_order(Quantity quantity) noexcept {
  switch (quantity) {
    case Quantity::velocity:
      return 1;
    case Quantity::acceleration:
      return 2;
    case Quantity::displacement:
    case Quantity::force:
    case Quantity::auxiliary:
      return 0;
  }
  return 0;
}

Complex response(const Channel& channel, double device_delay_s, double f_hz) noexcept {
  return response(channel, device_delay_s, Complex{0.0, kTwoPi * f_hz});
}

Complex response(const Channel& channel, double device_delay_s, Complex s) noexcept {
  return std::exp(-s * (channel.delay_s + device_delay_s)) * filter_response(channel.lowpass, false, s) *
         filter_response(channel.highpass, true, s);
}

LogSlopes response_slopes(const Channel& channel, double device_delay_s, double f_hz) noexcept {
  // A filter depends on f / corner alone. One central difference in ln f therefore gives the slopes by f and by corner.
  // The step 1e-4 leaves a truncation error of 1e-8 and a rounding error of 1e-12.
  constexpr double kStep = 1e-4;
  const auto log_slope = [f_hz](const Filter& filter, bool high) {
    if (filter.kind == FilterKind::none) return Complex{};
    return std::log(filter_response(filter, high, f_hz * (1 + kStep)) /
                    filter_response(filter, high, f_hz * (1 - kStep))) /
           (2 * kStep);
  };
  const Complex low = log_slope(channel.lowpass, false), high = log_slope(channel.highpass, true);
  LogSlopes slopes;
  slopes.frequency = (low + high) / f_hz + Complex{0.0, -kTwoPi * (channel.delay_s + device_delay_s)};
  if (channel.lowpass.hz > 0) slopes.lowpass_corner = -low / channel.lowpass.hz;
  if (channel.highpass.hz > 0) slopes.highpass_corner = -high / channel.highpass.hz;
  return slopes;
}

}  // namespace dwell
