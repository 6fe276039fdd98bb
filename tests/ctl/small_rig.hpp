// A small rig, one element between table and load cell, and recordings of it.
#pragma once

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>

namespace dwell::test {

inline constexpr const char* kRig = R"([rig]
name = "mount"
boundary = "clamped"
masses = []
[excitation]
frequency = 4.0
minimum = 2e-5
[[device]]
name = "recording"
driver = "replay"
file = "data.csv"
[[channel]]
name = "y0"
device = "recording"
measures = "displacement"
at = 0
unit = "mm"
[[channel]]
name = "reaction"
device = "recording"
measures = "force"
at = "ground"
unit = "N"
)";

// 5 s of an element of 240 kN/m and 310 N·s/m at 4 Hz; or of nothing.
inline std::string recording(double amplitude_mm, const std::string& header) {
  constexpr double omega = 2.0 * std::numbers::pi * 4.0;
  std::string text = header + "\n";
  for (int i = 0; i < 1000; ++i) {
    const double t_s = i / 200.0;
    const double force =
        1e-3 * amplitude_mm * (240000.0 * std::sin(omega * t_s) + omega * 310.0 * std::cos(omega * t_s));
    std::array<char, 120> line{};
    std::snprintf(line.data(), line.size(), "%.6f,%.12g,%.12g\n", t_s, amplitude_mm * std::sin(omega * t_s), force);
    text += line.data();
  }
  return text;
}

}  // namespace dwell::test
