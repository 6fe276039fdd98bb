// A device that samples by its own clock and whose readings reach the host late, for the tests of clock recovery.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace dwell {

struct StreamingDevice {
  enum class Delay { none, uniform, exponential };
  double rate_hz = 1000.0;       // nominal
  double off_ppm = 200.0;        // the true rate is off by up to that, drawn
  Delay delay = Delay::uniform;  // 0 … 1 ms; exponential: of 0.3 ms in the mean
  double lost = 0.0;             // part of the readings that never arrive
  double stall_every_s = 0.0;    // 0: never; about so often nothing arrives for 50 ms, then all of it
  double wander_ppm = 0.0;       // of the rate, a slow sine of 60 s
};

struct Arrival {
  double taken_s;  // when the device took the reading
  std::int64_t arrival_ns;
};

// From start_s to end_s, in the order of arrival (readings do not overtake each other).
inline std::vector<Arrival> arrivals(const StreamingDevice& device, double start_s, double end_s,
                                     std::mt19937_64& rng) {
  std::uniform_real_distribution<double> uniform(0, 1);
  std::exponential_distribution<double> exponential(1);
  const double period_s = 1.0 / (device.rate_hz * (1.0 + 1e-6 * device.off_ppm * (2.0 * uniform(rng) - 1.0)));
  const double wander_s = 1e-6 * device.wander_ppm * 60.0 / (2.0 * M_PI);
  const double first_s = start_s + period_s * uniform(rng);
  double stall_s = device.stall_every_s > 0 ? start_s + device.stall_every_s * uniform(rng) : 1e300;
  double stalled_until_s = 0.0, last_s = 0.0;
  std::vector<Arrival> out;
  for (long k = 0;; ++k) {
    const double even_s = first_s + static_cast<double>(k) * period_s;
    const double taken_s = even_s + wander_s * std::sin(2.0 * M_PI * even_s / 60.0);
    if (taken_s > end_s) return out;
    const bool lost = uniform(rng) < device.lost;
    double delay_s = 1e-4;
    if (device.delay == StreamingDevice::Delay::uniform) delay_s += 1e-3 * uniform(rng);
    if (device.delay == StreamingDevice::Delay::exponential) delay_s += 3e-4 * exponential(rng);
    if (taken_s > stall_s) {
      stalled_until_s = taken_s + 0.05;
      stall_s = taken_s + device.stall_every_s * (0.5 + uniform(rng));
    }
    if (lost) continue;
    last_s = std::max({taken_s + delay_s, stalled_until_s, last_s + 1e-6});
    out.push_back({taken_s, std::llround(last_s * 1e9)});
  }
}

}  // namespace dwell
