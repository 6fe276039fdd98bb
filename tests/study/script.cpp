#include "tests/study/script.hpp"

#include <cmath>

#include "core/base/angle.hpp"
#include "tests/study/bound.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

constexpr double kWait_s = 10.0;
constexpr double kBlock = 1024;  // samples of the first channel

}  // namespace

Script run_script(const Case& about) {
  const double begin_s = about.change_s + kWait_s, block_s = kBlock / about.lines[0].rate_hz;
  Script script{begin_s + block_s, {}};
  const double bin = std::round(about.rig.excitation.frequency_hz * block_s);
  std::vector<Complex> X;
  for (int c = 0; c < about.channels(); ++c) {
    const double rate_hz = about.lines[static_cast<std::size_t>(c)].rate_hz;
    const auto first = static_cast<std::int64_t>(std::ceil(begin_s * rate_hz));
    const auto count = static_cast<std::int64_t>(std::round(block_s * rate_hz));
    double mean = 0.0;
    std::vector<double> values;
    for (std::int64_t i = 0; i < count; ++i) {
      values.push_back(reading(about, c, first + i, instant_s(about, c, first + i)));
      mean += values.back() / static_cast<double>(count);
    }
    Complex sum = 0.0;
    for (std::int64_t i = 0; i < count; ++i) {
      const double part = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
      const double window = 1 - std::cos(kTwoPi * part);  // Hann
      sum += window * (values[static_cast<std::size_t>(i)] - mean) * std::polar(1.0, -kTwoPi * bin * part);
    }
    X.push_back(sum / static_cast<double>(count));
  }
  script.Z = stiffness_of(about, kTwoPi * about.rig.excitation.frequency_hz, X);
  return script;
}

}  // namespace dwell::study
