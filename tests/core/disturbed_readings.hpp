// The bench on which tests disturb readings as real devices do.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "core/dwell/pipeline.hpp"
#include "core/model/forward.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/expect.hpp"

namespace dwell {

inline constexpr std::uint16_t kCell = 3;  // the load cell of clamped_chain()

// clamped_chain() driven at 4 Hz, polled at 500 Hz, noise 1e-3 of each amplitude.
struct DisturbedReadings : testing::Test {
  Chain chain = clamped_chain();
  Rig rig = rig_of(chain, 4);
  double rate_hz = 500.0;
  std::mt19937_64 rng{4};
  std::uniform_real_distribution<double> uniform{0, 1};

  std::vector<double> sigma(double part = 1e-3) const {
    const auto steady = steady_response(chain, 2 * M_PI * 4, 0.002);
    std::vector<double> out;
    for (const auto& y : steady.Y) out.push_back(part * std::abs(y));
    out.push_back(part * std::abs(steady.F));
    return out;
  }
  double force() const { return std::abs(steady_response(chain, 2 * M_PI * 4, 0.002).F); }

  Dwell measured(const std::function<void(Record&, double)>& alter, double until_s = 30, double noise = 1e-3) {
    Bench bench(chain, rig, steady_drive(4), DrivenChain::Start::rest,
                {.rate_hz = rate_hz, .sigma = noise > 0 ? sigma(noise) : std::vector<double>{}}, 7);
    bench.alter = alter;
    bench.run(until_s);
    conditions.clear();
    for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c)
      conditions.emplace_back(to_string(bench.pipeline.channel(c).condition));
    bench.finish();
    return bench.dwells.empty() ? bench.pipeline.current() : bench.dwells.back();
  }
  std::vector<std::string> conditions;

  // No coefficient is more than k u off.
  void expect_no_wrong_number(const Dwell& dwell, const std::string& what, double k = 5) const {
    for (std::size_t e = 0; e < dwell.elements.size(); ++e) {
      const ElementEstimate& element = dwell.elements[e];
      if (!element.identifiable) continue;
      EXPECT_LT(std::abs(element.stiffness.value - chain.stiffness[e]) / element.stiffness.u, k)
          << what << ", c_" << e + 1;
      EXPECT_LT(std::abs(element.damping.value - chain.damping[e]) / element.damping.u, k) << what << ", r_" << e + 1;
    }
  }
  static bool says(const Dwell& dwell, const std::string& words) {
    const auto in = [&](const Warning& warning) { return warning.what.find(words) != std::string::npos; };
    return std::any_of(dwell.warnings.begin(), dwell.warnings.end(), in);
  }
  static std::string all(const Dwell& dwell) {
    std::string out = dwell.settling_reason;
    for (const Warning& warning : dwell.warnings) out += "\n  " + warning.what;
    for (const ElementEstimate& element : dwell.elements) out += "\n  " + element.reason;
    return out;
  }
};

}  // namespace dwell
