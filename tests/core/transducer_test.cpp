#include "core/rig/transducer.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell {
namespace {

double phase_degrees(const Filter& filter, bool high, double f_hz) {
  return std::arg(filter_response(filter, high, f_hz)) * 180 / M_PI;
}

TEST(Transducer, TurnsThePhaseAsTheMethodPageSays) {
  // method, section 5: order 2 at 250 Hz driven at 25 Hz; AC coupling at 0.5 Hz driven at 4 Hz.
  EXPECT_NEAR(phase_degrees({FilterKind::butterworth, 2, 250, 0}, false, 25), -8.1, 0.05);
  EXPECT_NEAR(phase_degrees({FilterKind::rc, 2, 250, 0}, false, 25), -11.4, 0.05);
  EXPECT_NEAR(phase_degrees({FilterKind::rc, 1, 0.5, 0}, true, 4), 7.1, 0.05);
}

TEST(Transducer, ButterworthAndBesselFallToHalfPowerAtTheCorner) {
  for (int order = 1; order <= 8; ++order)
    for (const FilterKind kind : {FilterKind::butterworth, FilterKind::bessel})
      for (const bool high : {false, true}) {
        const Filter filter{kind, order, 40, 0};
        EXPECT_NEAR(std::norm(filter_response(filter, high, 40)), 0.5, 1e-9) << order;
        EXPECT_NEAR(std::abs(filter_response(filter, high, high ? 4e6 : 4e-4)), 1.0, 1e-6) << order;
      }
}

TEST(Transducer, BesselDelaysAllFrequenciesAlike) {
  const Filter filter{FilterKind::bessel, 4, 100, 0};
  const auto delay = [&](double f) { return -std::arg(filter_response(filter, false, f)) / (2 * M_PI * f); };
  EXPECT_NEAR(delay(20) / delay(1), 1.0, 1e-4);
  // Order 4, corner 1 rad/s: the group delay is 2.11391 s (Bessel tables), here at 2π·100.
  EXPECT_NEAR(delay(1) * 2 * M_PI * 100, 2.1139, 1e-3);
}

TEST(Transducer, SlopesAreThoseOfTheResponse) {
  Channel channel;
  channel.delay_s = 3e-4;
  channel.lowpass = {FilterKind::bessel, 3, 80, 1};
  channel.highpass = {FilterKind::rc, 1, 0.7, 0.1};
  const double f = 11, step = 1e-5;
  const LogSlopes slopes = response_slopes(channel, 1e-4, f);
  const auto numeric =
      (std::log(response(channel, 1e-4, f + step)) - std::log(response(channel, 1e-4, f - step))) / (2 * step);
  EXPECT_NEAR(std::abs(slopes.frequency - numeric), 0, 1e-7);
  Channel moved = channel;
  moved.lowpass.hz += step;
  const auto by_corner = (std::log(response(moved, 1e-4, f)) - std::log(response(channel, 1e-4, f))) / step;
  EXPECT_NEAR(std::abs(slopes.lowpass_corner - by_corner), 0, 1e-6);
}

}  // namespace
}  // namespace dwell
