#include "core/verify/virtual_test.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/base/angle.hpp"
#include "core/base/complex.hpp"
#include "core/base/instants.hpp"
#include "core/model/driven_chain.hpp"
#include "core/model/forward.hpp"
#include "core/motion/filter_sections.hpp"
#include "core/rig/transducer.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

// Instants about every step_s, each moved by up to ± `jitter` steps.
Instants jittered(double step_s, double until_s, double jitter, std::uint64_t seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> uniform(-jitter, jitter);
  Instants out;
  for (int i = 0; i * step_s < until_s; ++i) out.push_back(to_ns(std::max(0.0, (i + uniform(rng)) * step_s)) + i);
  return out;
}

VirtualTestInput reading_of(const std::function<double(double)>& table, const Instants& instants,
                            std::int64_t delay_ns = 0) {
  Eigen::MatrixXd values(1, static_cast<Eigen::Index>(instants.size()));
  Instants of_motion;
  for (std::size_t i = 0; i < instants.size(); ++i) {
    values(0, static_cast<Eigen::Index>(i)) = table(to_s(instants[i]));
    of_motion.push_back(instants[i] - delay_ns);
  }
  return {of_motion, values};
}

// The equations of motion as they stand in docs/method.md, by Runge and Kutta in steps of 1/100 of an interval: y and
// y' of the masses at each of `instants` under the table's spline.
std::vector<Eigen::VectorXd> integrated(const Chain& chain, const VirtualTestInput& input, const Instants& instants) {
  const int n = chain.mass_count();
  const auto at = [](const Eigen::VectorXd& x, int i) { return x(static_cast<Eigen::Index>(i)); };
  const auto slope = [&](const Eigen::VectorXd& x, double y0, double v0) {
    Eigen::VectorXd out(2 * n);
    const auto force = [&](int k) {  // of element k on mass k-1
      const double y = k <= n ? at(x, k - 1) : 0.0, v = k <= n ? at(x, n + k - 1) : 0.0;
      const double y_before = k > 1 ? at(x, k - 2) : y0, v_before = k > 1 ? at(x, n + k - 2) : v0;
      return chain.stiffness[static_cast<std::size_t>(k - 1)] * (y - y_before) +
             chain.damping[static_cast<std::size_t>(k - 1)] * (v - v_before);
    };
    for (int k = 1; k <= n; ++k) {
      out(k - 1) = at(x, n + k - 1);
      out(n + k - 1) =
          ((k < chain.element_count() ? force(k + 1) : 0.0) - force(k)) / chain.masses[static_cast<std::size_t>(k - 1)];
    }
    return out;
  };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(2 * n);
  std::vector<Eigen::VectorXd> out;
  std::size_t knot = 0;
  std::int64_t now_ns = input.knot_ns(0);
  Eigen::MatrixXd u(4, 1);
  const auto table = [&](double s) {
    input.at(knot, s, u);
    return std::pair{u(0), u(1)};
  };
  const auto go_to = [&](std::int64_t t_ns) {
    constexpr int kSteps = 100;
    const double h = to_s(t_ns - now_ns) / kSteps, from_s = to_s(now_ns - input.knot_ns(knot));
    for (int i = 0; i < kSteps && t_ns > now_ns; ++i) {
      const double s = from_s + i * h;
      const auto [y0, v0] = table(s);
      const auto [ym, vm] = table(s + h / 2);
      const auto [y1, v1] = table(s + h);
      const Eigen::VectorXd k1 = slope(x, y0, v0), k2 = slope(x + h / 2 * k1, ym, vm);
      const Eigen::VectorXd k3 = slope(x + h / 2 * k2, ym, vm), k4 = slope(x + h * k3, y1, v1);
      x += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    now_ns = t_ns;
  };
  for (const std::int64_t t_ns : instants) {
    for (; knot + 2 < input.knots() && input.knot_ns(knot + 1) <= t_ns; ++knot) go_to(input.knot_ns(knot + 1));
    go_to(t_ns);
    out.push_back(x);
  }
  return out;
}

class VirtualTestOfChain : public testing::TestWithParam<bool> {
 protected:
  [[nodiscard]] static Chain chain() { return GetParam() ? clamped_chain() : free_chain(); }
};

TEST_P(VirtualTestOfChain, IsTheExactSolutionForTheInterpolatedInput) {
  const Chain chain = this->chain();
  const Rig rig = rig_of(chain, 4.0);
  // Fifteen readings a period, begun at once, amplitude and frequency wandering: nothing of it is steady.
  const VirtualTestInput input = reading_of(
      [](double t) { return 5e-3 * (1 + 0.3 * std::sin(1.7 * t)) * std::sin(kTwoPi * 4.0 * t + std::sin(t)); },
      jittered(1 / 60.0, 6.0, 0.3, 1));
  std::vector<Instants> asked(rig.channels.size());
  for (std::size_t c = 1; c < asked.size(); ++c) asked[c] = jittered(1 / 50.0, 5.9, 0.4, 10 + c);
  const VirtualTest test(rig, chain, 0);
  ASSERT_EQ(test.fault(), "");
  const auto seen = test.play(input, Eigen::MatrixXd::Zero(test.model().states(), 1), asked);
  for (std::size_t c = 1; c < asked.size(); ++c) {
    const auto exact = integrated(chain, input, asked[c]);
    double largest = 0.0, off = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const Eigen::Index n = chain.mass_count();
      const double expected =
          rig.channels[c].measures == Quantity::force
              ? chain.stiffness.back() * exact[i](n - 1) + chain.damping.back() * exact[i](2 * n - 1)
              : exact[i](static_cast<Eigen::Index>(c) - 1);
      largest = std::max(largest, std::abs(expected));
      off = std::max(off, std::abs(seen[c](0, static_cast<Eigen::Index>(i)) - expected));
    }
    EXPECT_LT(off, 1e-8 * largest) << rig.channels[c].name;  // what Runge and Kutta leave; asked for: 1e-6
  }
}

TEST_P(VirtualTestOfChain, PredictsAStartFromRest) {
  const Chain chain = this->chain();
  const Rig rig = rig_of(chain, 4.0);
  DrivenChain truth(chain, {.frequency_hz = 4.0, .amplitude = 5e-3, .ramp_s = 0.5}, DrivenChain::Start::rest);
  const Instants grid = jittered(1 / 400.0, 6.0, 0.0, 1);
  const VirtualTestInput input = reading_of([&](double t) { return truth.at(t).y[0]; }, grid);
  const VirtualTest test(rig, chain, 0);
  const auto seen = test.play(input, Eigen::MatrixXd::Zero(test.model().states(), 1),
                              std::vector<Instants>(rig.channels.size(), grid));
  for (std::size_t c = 1; c < rig.channels.size(); ++c) {
    double largest = 0.0, off = 0.0;
    for (std::size_t i = 0; i < grid.size(); ++i) {
      const double expected = exact_reading(rig, truth.at(to_s(grid[i])), static_cast<int>(c));
      largest = std::max(largest, std::abs(expected));
      off = std::max(off, std::abs(seen[c](0, static_cast<Eigen::Index>(i)) - expected));
    }
    EXPECT_LT(off, 1e-5 * largest) << rig.channels[c].name;  // of the spline, where the ramp has its corners
  }
}

INSTANTIATE_TEST_SUITE_P(Boundaries, VirtualTestOfChain, testing::Bool(),
                         [](const auto& about) { return about.param ? "Clamped" : "Free"; });

// Every channel's reading in the steady state, by the transducers' frequency responses.
void expect_steady(const Rig& rig, const Chain& chain, double f_hz) {
  const Complex s{0.0, kTwoPi * f_hz};
  const SteadyResponse steady = steady_response(chain, kTwoPi * f_hz, 5e-3);
  const auto reads = [&](const Channel& channel) {
    const auto Y = [&](int k) { return k == kGround ? Complex{} : steady.Y[static_cast<std::size_t>(k)]; };
    Complex o = channel.measures == Quantity::force ? (channel.force_on_mass ? -steady.F : steady.F) : Y(channel.at);
    if (channel.relative_to) o -= Y(*channel.relative_to);
    return o * std::pow(s, derivative_order(channel.measures)) * response(channel, device_delay_s(rig, channel), s);
  };
  const Complex U = reads(rig.channels[0]);
  const Instants grid = jittered(1 / (200 * f_hz), 20.0, 0.3, 5);
  const VirtualTest test(rig, chain, 0);
  ASSERT_EQ(test.fault(), "");
  const VirtualTestInput input =
      reading_of([&](double t) { return (U * std::exp(s * t)).imag(); }, grid, test.model().delay_ns(0));
  Eigen::MatrixXd initial = Eigen::MatrixXd::Zero(test.model().states(), 1);
  const Complex at_start = U * std::exp(s * to_s(grid[0]));
  for (int j = 0; j < test.model().integrals(); ++j)
    initial(test.model().chain_states() + j) = (at_start / std::pow(s, j + 1)).imag();
  const auto seen = test.play(input, initial, std::vector<Instants>(rig.channels.size(), grid));
  for (std::size_t c = 1; c < rig.channels.size(); ++c) {
    if (!test.model().predicts(static_cast<int>(c))) continue;
    const Complex X = reads(rig.channels[c]);
    double off = 0.0;
    for (std::size_t i = grid.size() / 2; i < grid.size() - 100; ++i)
      off =
          std::max(off, std::abs(seen[c](0, static_cast<Eigen::Index>(i)) - (X * std::exp(s * to_s(grid[i]))).imag()));
    EXPECT_LT(off, 2e-5 * std::abs(X)) << rig.channels[c].name;
  }
}

Rig rig_of_every_transducer() {
  Rig rig = rig_of(clamped_chain(), 4.0);
  rig.devices = {{"bus", 0.004, 0.0}};
  for (Channel& channel : rig.channels) channel.device = 0;
  const auto add = [&](const char* name, Quantity measures, int at, std::optional<int> relative_to) {
    Channel channel = rig.channels[1];
    channel.name = name;
    channel.measures = measures;
    channel.at = at;
    channel.relative_to = relative_to;
    rig.channels.push_back(channel);
    return &rig.channels.back();
  };
  rig.channels.reserve(16);
  add("across 2", Quantity::displacement, 2, 1);
  add("across 1", Quantity::displacement, 1, 0)->delay_s = 0.002;
  add("velocity", Quantity::velocity, 2, std::nullopt)->lowpass = {FilterKind::bessel, 3, 60.0};
  add("acceleration", Quantity::acceleration, 1, std::nullopt)->highpass = {FilterKind::rc, 2, 0.5};
  add("acceleration across 1", Quantity::acceleration, 1, 0)->lowpass = {FilterKind::butterworth, 4, 80.0};
  add("on mass", Quantity::force, kGround, std::nullopt)->force_on_mass = true;
  return rig;
}

TEST(VirtualTest, PredictsEveryKindOfTransducer) { expect_steady(rig_of_every_transducer(), clamped_chain(), 4.0); }

TEST(VirtualTest, UndoesTheTablesOwnTransducer) {
  for (const Quantity measures : {Quantity::displacement, Quantity::velocity, Quantity::acceleration}) {
    Rig rig = rig_of_every_transducer();
    rig.channels[0].measures = measures;
    rig.channels[0].delay_s = 0.003;
    rig.channels[0].lowpass = {FilterKind::butterworth, 2, 100.0};
    rig.channels[0].highpass = {FilterKind::rc, 1, 0.3};
    expect_steady(rig, clamped_chain(), 4.0);
  }
}

TEST(VirtualTest, CoversOneElementBetweenTableAndLoadCell) {
  const Chain chain{Boundary::clamped, {}, {240000.0}, {310.0}};
  expect_steady(rig_of(chain, 4.0), chain, 4.0);
}

TEST(VirtualTest, SaysWhichLowPassCannotBeUndone) {
  Rig rig = rig_of(free_chain(), 4.0);
  rig.channels[0].lowpass = {FilterKind::bessel, 3, 100.0};
  const VirtualTest test(rig, free_chain(), 0);
  EXPECT_NE(test.fault().find("the low-pass of y0 is of order 3"), std::string::npos);
}

// A displacement through a low-pass of order 2 gives the table's velocity at most.
TEST(VirtualTest, SaysWhichChannelItCannotPredict) {
  Rig rig = rig_of_every_transducer();
  rig.channels[0].lowpass = {FilterKind::butterworth, 2, 100.0};
  const VirtualTest test(rig, clamped_chain(), 0);
  EXPECT_EQ(test.fault(), "");
  for (std::size_t c = 0; c < rig.channels.size(); ++c)
    EXPECT_EQ(test.model().predicts(static_cast<int>(c)), rig.channels[c].name != "acceleration across 1");
}

TEST(VirtualTest, LeavesOutInstantsBeyondTheInput) {
  const Rig rig = rig_of(free_chain(), 4.0);
  const VirtualTestInput input = reading_of([](double) { return 1e-3; }, {100, 200, 300, 400});
  const VirtualTest test(rig, free_chain(), 0);
  const auto seen = test.play(input, Eigen::MatrixXd::Zero(test.model().states(), 1), {{}, {50, 100, 400, 401}, {}});
  EXPECT_TRUE(std::isnan(seen[1](0, 0)));
  EXPECT_TRUE(std::isfinite(seen[1](0, 1)));
  EXPECT_TRUE(std::isfinite(seen[1](0, 2)));
  EXPECT_TRUE(std::isnan(seen[1](0, 3)));
}

// The polynomial of a filter answers as the filter does, high-pass and low-pass, within its poles too.
TEST(VirtualTest, WritesEveryFilterAsAPolynomial) {
  for (const FilterKind kind : {FilterKind::butterworth, FilterKind::bessel, FilterKind::rc})
    for (int order = 1; order <= 8; ++order) {
      const Filter filter{kind, order, 3.0};
      const std::vector<double> p = filter_polynomial(filter);
      const Complex s{0.0, 0.8};
      Complex P = 0.0;
      for (std::size_t j = 0; j < p.size(); ++j) P += p[j] * std::pow(s, static_cast<double>(j));
      EXPECT_LT(std::abs(P * filter_response(filter, false, s * kTwoPi * 3.0) - 1.0), 1e-9) << order;
    }
}

}  // namespace
}  // namespace dwell
