// A second of 64 channels at 10 kHz, eight to a device: 16-bit readings of a sine over most of the range, with noise.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "core/stream/record.hpp"

namespace dwell::record {

enum class Instants {
  shared,     // the eight of a device share instant and stamp
  recovered,  // each sample has an instant of its own, evenly spaced, and a stamp of its own
  irregular,  // each has an instant and a stamp of its own, both irregular
};

// Noise: 30 LSB. Stamps, and irregular instants, come late by half of a normal distribution of 5 µs.
inline std::vector<Record> noisy_signals(Instants instants) {
  constexpr std::int64_t kBegin = 7'200'000'000'000;
  constexpr double kTurn = 2 * 3.14159265358979323846 * 20e-9;  // 20 Hz, per ns
  std::mt19937_64 random(12);
  std::normal_distribution<double> normal;
  const auto late = [&] { return static_cast<std::int64_t>(5000 * std::abs(normal(random))); };
  std::vector<Record> records;
  for (std::int64_t scan = 0; scan < 10'000; ++scan) {
    for (std::uint16_t device = 0; device < 8; ++device) {
      const std::int64_t t_ns = kBegin + scan * 100'000 + device * 11'000;
      const std::int64_t stamped_ns = t_ns + 20'000 + late();
      for (std::uint16_t i = 0; i < 8; ++i) {
        Record r{.t_ns = t_ns, .stamped_ns = stamped_ns, .t_half_ns = 1200};
        r.channel = static_cast<std::uint16_t>(device * 8 + i);
        if (instants != Instants::shared) {
          r.t_ns += i * 1500 + (instants == Instants::irregular ? late() : 0);
          r.stamped_ns = r.t_ns + 20'000 + late();
        }
        const double phase = kTurn * static_cast<double>(r.t_ns - kBegin) + i;
        r.value = std::round(28'000 * std::sin(phase) + 30 * normal(random));
        records.push_back(r);
      }
    }
  }
  std::stable_sort(records.begin(), records.end(), [](const Record& a, const Record& b) { return a.t_ns < b.t_ns; });
  return records;
}

}  // namespace dwell::record
