// The forward model against independent truths: the differential equations themselves, a closed form, a small-step
// integrator, and the golden phasors.
#include "core/model/forward.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "core/model/driven_chain.hpp"

namespace dwell {
namespace {

using std::numbers::pi;

Chain random_chain(std::mt19937_64& random, int n, Boundary boundary) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  Chain chain;
  chain.boundary = boundary;
  for (int i = 0; i < n; ++i) chain.masses.push_back(1.0 + 30.0 * unit(random));
  for (int i = 0; i < chain.element_count(); ++i) {
    chain.stiffness.push_back(5e3 + 1e5 * unit(random));
    chain.damping.push_back(20.0 + 200.0 * unit(random));
  }
  return chain;
}

Chain three_masses() { return {Boundary::clamped, {12, 8, 5}, {24e3, 15e3, 9e3, 12e3}, {60, 45, 30, 40}}; }

// The net force on mass k by equation (1), written out independently of the model.
double net_force(const Chain& chain, const std::vector<double>& y, const std::vector<double>& v, int k) {
  const auto i = static_cast<std::size_t>(k);
  double force = -chain.damping[i - 1] * (v[i] - v[i - 1]) - chain.stiffness[i - 1] * (y[i] - y[i - 1]);
  if (k < chain.element_count()) {
    const double next_y = k < chain.mass_count() ? y[i + 1] : 0.0;
    const double next_v = k < chain.mass_count() ? v[i + 1] : 0.0;
    force -= chain.damping[i] * (v[i] - next_v) + chain.stiffness[i] * (y[i] - next_y);
  }
  return force;
}

TEST(Chain, SaysWhatIsWrongWithIt) {
  EXPECT_EQ(three_masses().fault(), "");
  EXPECT_EQ((Chain{Boundary::clamped, {}, {1e4}, {5}}.fault()), "");
  EXPECT_NE((Chain{Boundary::free, {}, {}, {}}.fault()), "");
  EXPECT_NE((Chain{Boundary::free, {-3}, {1}, {1}}.fault()).find("masses[0]"), std::string::npos);
  EXPECT_NE((Chain{Boundary::clamped, {3}, {1}, {1, 2}}.fault()).find("stiffness has 1 values"), std::string::npos);
  EXPECT_NE((Chain{Boundary::free, {3}, {1}, {std::nan("")}}.fault()).find("damping[0]"), std::string::npos);
}

TEST(SteadyResponse, IsTheClosedFormForOneMass) {
  const Chain chain{Boundary::free, {7.0}, {9e3}, {55.0}};
  for (const double hz : {0.0, 1.0, 5.7, 5.706, 40.0}) {
    const double omega = 2 * pi * hz;
    const Phasor Z(9e3, omega * 55.0);
    const Phasor expected = Z * Phasor(0.002, 0.001) / (Z - omega * omega * 7.0);
    EXPECT_LT(std::abs(steady_response(chain, omega, {0.002, 0.001}).Y[1] - expected), 1e-15 * std::abs(expected) * 10);
  }
}

TEST(SteadyResponse, OfAnElementAloneIsItsForce) {
  const Chain chain{Boundary::clamped, {}, {2e5}, {300.0}};
  const auto response = steady_response(chain, 50.0, {0.0, 0.001});
  ASSERT_EQ(response.Y.size(), 1U);
  EXPECT_LT(std::abs(response.F - Phasor(2e5, 15e3) * Phasor(0, 0.001)), 1e-12);
}

TEST(SteadyResponse, SurvivesAVanishingPivot) {
  // Undamped, ω exactly at the natural frequency of mass 1 between its two springs: the first pivot is zero.
  const Chain chain{Boundary::free, {2.0, 3.0}, {100.0, 100.0}, {0.0, 0.0}};
  const auto response = steady_response(chain, 10.0, 1.0);
  EXPECT_NEAR(response.Y[2].real(), -1.0, 1e-12);  // 0·Y_1 - 100 Y_2 = 100
  EXPECT_NEAR(response.Y[1].real(), 2.0, 1e-12);   // -100 Y_1 + (100 - 300) Y_2 = 0
}

TEST(SteadyResponse, ReproducesTheGoldenPhasors) {
  std::ifstream stream(DWELL_GOLDEN_DIR "/phasors.json");
  const auto golden = nlohmann::json::parse(stream);
  int cases = 0;
  for (const auto& item : golden["cases"]) {
    Chain chain;
    chain.boundary = item["boundary"] == "clamped" ? Boundary::clamped : Boundary::free;
    chain.masses = item["masses_kg"].get<std::vector<double>>();
    chain.stiffness = item["stiffness_n_per_m"].get<std::vector<double>>();
    chain.damping = item["damping_n_s_per_m"].get<std::vector<double>>();
    ASSERT_EQ(chain.fault(), "") << item["name"];
    std::vector<Phasor> Y;
    for (const auto& y : item["displacement"])
      Y.push_back(std::polar(y["amplitude_m"].get<double>(), y["phase_rad"].get<double>()));
    const auto response = steady_response(chain, 2 * pi * item["frequency_hz"].get<double>(), Y[0]);
    ASSERT_EQ(response.Y.size(), Y.size());
    for (std::size_t k = 0; k < Y.size(); ++k)
      EXPECT_LT(std::abs(response.Y[k] - Y[k]), 1e-9 * std::abs(Y[k])) << item["name"] << " y" << k;
    if (chain.boundary == Boundary::clamped) {
      const auto& f = item["force_on_ground"];
      const Phasor F = std::polar(f["amplitude_n"].get<double>(), f["phase_rad"].get<double>());
      EXPECT_LT(std::abs(response.F - F), 1e-9 * std::abs(F)) << item["name"];
    }
    ++cases;
  }
  EXPECT_GT(cases, 5);
}

TEST(NaturalValues, AreTheClosedFormForOneMass) {
  const auto values = natural_values({Boundary::free, {2.0}, {800.0}, {8.0}});
  ASSERT_EQ(values.size(), 2U);
  for (const auto& value : values) {
    EXPECT_NEAR(value.real(), -2.0, 1e-12);
    EXPECT_NEAR(std::abs(value.imag()), std::sqrt(400.0 - 4.0), 1e-11);
  }
  EXPECT_NEAR(slowest_decay_rate({Boundary::free, {2.0}, {800.0}, {8.0}}), 2.0, 1e-12);
  EXPECT_EQ(slowest_decay_rate({Boundary::clamped, {}, {800.0}, {8.0}}), std::numeric_limits<double>::infinity());
}

TEST(NaturalValues, MakeTheDynamicStiffnessSingular) {
  std::mt19937_64 random(11);
  const Chain chain = random_chain(random, 5, Boundary::clamped);
  const auto values = natural_values(chain);
  ASSERT_EQ(values.size(), 10U);
  for (const auto& value : values) {
    std::vector<Phasor> at(5, 1.0), beside(5, 1.0);
    solve_dynamic(chain, value, at);
    solve_dynamic(chain, value * Phasor(1.0, 0.05), beside);
    EXPECT_GT(std::abs(at[2]), 1e6 * std::abs(beside[2]));
  }
}

TEST(DrivenChain, TendsToTheSteadyResponse) {
  const Chain chain = three_masses();
  DrivenChain driven(chain, {.frequency_hz = 4.0, .amplitude = 0.005, .offset = 0.001, .ramp_s = 0.3},
                     DrivenChain::Start::rest);
  const double omega = 2 * pi * 4.0;
  const auto steady = steady_response(chain, omega, 0.005);
  const auto standing = steady_response(chain, 0.0, 0.001);
  const double long_enough = 40.0 / slowest_decay_rate(chain);
  for (int i = 0; i < 20; ++i) {
    const double t = long_enough + 0.0137 * i;
    const auto& motion = driven.at(t);
    const Phasor turn = std::polar(1.0, omega * t);
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_NEAR(motion.y[k], (steady.Y[k] * turn).imag() + standing.Y[k].real(), 1e-14);
    EXPECT_NEAR(motion.ground_force, (steady.F * turn).imag() + standing.F.real(), 1e-9);
  }
}

TEST(DrivenChain, BegunSteadyHasNoTransient) {
  const Chain chain = three_masses();
  DrivenChain driven(chain, {.frequency_hz = 4.0, .amplitude = 0.005, .offset = 0, .ramp_s = 5.0},
                     DrivenChain::Start::steady);
  const auto steady = steady_response(chain, 8 * pi, 0.005);
  for (std::size_t k = 0; k < 4; ++k)
    EXPECT_NEAR(driven.at(0.03).y[k], (steady.Y[k] * std::polar(1.0, 0.24 * pi)).imag(), 1e-16);
}

// Velocity and acceleration are the derivatives of the displacement, and mass times acceleration is the force: through
// the ramp, after it, and with harmonics.
TEST(DrivenChain, SatisfiesTheEquationsOfMotion) {
  std::mt19937_64 random(5);
  for (const Boundary boundary : {Boundary::free, Boundary::clamped})
    for (const int n : {1, 2, 6}) {
      const Chain chain = random_chain(random, n, boundary);
      DrivenChain driven(chain,
                         {.frequency_hz = 3.0,
                          .amplitude = 0.004,
                          .offset = 0.002,
                          .ramp_s = 0.5,
                          .harmonics = {{2, 0.0005, 0.7}, {5, 0.0001, -2.0}}},
                         DrivenChain::Start::rest);
      for (const double t : {0.1, 0.37, 0.499, 0.502, 0.9, 3.0}) {
        const double h = 2e-5;
        const ChainMotion before = driven.at(t - h), middle = driven.at(t), after = driven.at(t + h);
        for (int k = 0; k <= n; ++k) {
          const auto i = static_cast<std::size_t>(k);
          // Central differences err by h²/6 of the third derivative, and by the ramp's ends not at all.
          EXPECT_NEAR((after.y[i] - before.y[i]) / (2 * h), middle.velocity[i], 1e-6);
          EXPECT_NEAR((after.velocity[i] - before.velocity[i]) / (2 * h), middle.acceleration[i], 1e-4);
          if (k > 0) {
            EXPECT_NEAR(net_force(chain, middle.y, middle.velocity, k), chain.masses[i - 1] * middle.acceleration[i],
                        1e-9);
          }
        }
      }
    }
}

TEST(DrivenChain, AgreesWithASmallStepIntegrator) {
  std::mt19937_64 random(3);
  const Chain chain = random_chain(random, 3, Boundary::clamped);
  const double omega = 2 * pi * 4.5, A = 0.003;
  std::vector<double> y{A * 0, 0.001, -0.002, 0.0005}, v{A * omega, 0.1, 0.0, -0.2};
  DrivenChain driven(chain, {.frequency_hz = 4.5, .amplitude = A, .offset = 0, .ramp_s = 0}, DrivenChain::Start::rest);
  driven.set_state(0.0, {y[1], y[2], y[3]}, {v[1], v[2], v[3]});

  const auto rates = [&](double t, const std::vector<double>& y_now, const std::vector<double>& v_now) {
    std::vector<double> y_full = y_now, v_full = v_now, a(4);
    y_full[0] = A * std::sin(omega * t);
    v_full[0] = A * omega * std::cos(omega * t);
    for (int k = 1; k <= 3; ++k)
      a[static_cast<std::size_t>(k)] =
          net_force(chain, y_full, v_full, k) / chain.masses[static_cast<std::size_t>(k) - 1];
    return std::pair{v_full, a};
  };
  const auto moved = [](const std::vector<double>& x, const std::vector<double>& rate, double h) {
    std::vector<double> out = x;
    for (std::size_t i = 0; i < x.size(); ++i) out[i] += h * rate[i];
    return out;
  };
  const double h = 1e-5;
  for (int i = 0; i < 100000; ++i) {
    const double t = i * h;
    const auto [v1, a1] = rates(t, y, v);
    const auto [v2, a2] = rates(t + h / 2, moved(y, v1, h / 2), moved(v, a1, h / 2));
    const auto [v3, a3] = rates(t + h / 2, moved(y, v2, h / 2), moved(v, a2, h / 2));
    const auto [v4, a4] = rates(t + h, moved(y, v3, h), moved(v, a3, h));
    for (std::size_t k = 1; k < 4; ++k) {
      y[k] += h / 6 * (v1[k] + 2 * v2[k] + 2 * v3[k] + v4[k]);
      v[k] += h / 6 * (a1[k] + 2 * a2[k] + 2 * a3[k] + a4[k]);
    }
  }
  const auto& motion = driven.at(1.0);
  for (std::size_t k = 1; k < 4; ++k) {
    EXPECT_NEAR(motion.y[k], y[k], 1e-11);
    EXPECT_NEAR(motion.velocity[k], v[k], 1e-9);
  }
}

TEST(DrivenChain, IsExactAtCriticalDamping) {
  // m = 1, c = 100, r = 20: both natural values are -10, and no basis of eigenvectors exists.
  DrivenChain driven({Boundary::free, {1.0}, {100.0}, {20.0}}, {}, DrivenChain::Start::rest);
  driven.set_state(0.0, {0.01}, {0.3});
  for (const double t : {0.001, 0.1, 0.77, 2.5}) {
    const double expected = (0.01 + (0.3 + 10 * 0.01) * t) * std::exp(-10 * t);
    EXPECT_NEAR(driven.at(t).y[1], expected, 1e-13 * (0.01 + std::abs(expected)));
  }
}

TEST(DrivenChain, KeepsTheEnergyOfAnUndampedChain) {
  Chain chain{Boundary::clamped, {2.0, 3.0}, {4e3, 5e3, 6e3}, {0.0, 0.0, 0.0}};
  DrivenChain driven(chain, {}, DrivenChain::Start::rest);
  driven.set_state(0.0, {0.01, -0.004}, {0.2, 0.0});
  const auto energy = [&](double t) {
    const auto& m = driven.at(t);
    return 0.5 * (2 * m.velocity[1] * m.velocity[1] + 3 * m.velocity[2] * m.velocity[2] + 4e3 * m.y[1] * m.y[1] +
                  5e3 * std::pow(m.y[2] - m.y[1], 2) + 6e3 * m.y[2] * m.y[2]);
  };
  const double at_first = energy(0.0);
  // An hour is 2e7 units of the propagator's smallest step: rounding, 1e-16 of each, is all that is left.
  for (const double t : {0.01, 1.0, 60.0, 3600.0}) EXPECT_NEAR(energy(t) / at_first, 1.0, 1e-8);
}

TEST(DrivenChain, GoesOnSmoothlyWhenTheDriveChanges) {
  const Chain chain = three_masses();
  Drive drive{.frequency_hz = 4.0, .amplitude = 0.005, .offset = 0.001, .ramp_s = 0.2, .harmonics = {{3, 1e-4, 0.5}}};
  DrivenChain driven(chain, drive, DrivenChain::Start::rest);
  double t = 0.0;
  // Also in the middle of a ramp: 0.73 - 0.61 < 0.2.
  for (const double change_s : {0.61, 0.73, 2.0, 3.1}) {
    const ChainMotion before = driven.at(change_s);
    const double theta = driven.table_phase(change_s);
    drive.frequency_hz += 0.7;
    drive.amplitude *= t > 1.0 ? 0.0 : 1.3;
    driven.set_drive(change_s, drive);
    const ChainMotion& after = driven.at(change_s);
    EXPECT_NEAR(driven.table_phase(change_s), theta, 1e-12);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(after.y[k], before.y[k], 1e-15);
    for (std::size_t k = 1; k < 4; ++k) EXPECT_NEAR(after.velocity[k], before.velocity[k], 1e-13);
    t = change_s;
  }
  EXPECT_NEAR(driven.at(60.0).y[1], steady_response(chain, 0.0, 0.001).Y[1].real(), 1e-4);
}

TEST(DrivenChain, WithoutARampKeepsTheMassesButNotTheTable) {
  DrivenChain driven(three_masses(), {.frequency_hz = 4.0, .amplitude = 0.005, .offset = 0, .ramp_s = 0},
                     DrivenChain::Start::rest);
  const ChainMotion before = driven.at(1.0625);  // a quarter of a period: the table at its peak
  driven.set_drive(1.0625, {});
  EXPECT_NEAR(before.y[0], 0.005, 1e-12);
  EXPECT_EQ(driven.at(1.0625).y[0], 0.0);
  EXPECT_NEAR(driven.at(1.0625).y[1], before.y[1], 1e-15);
}

TEST(DrivenChain, ManyMassesStayExact) {
  std::mt19937_64 random(9);
  const Chain chain = random_chain(random, 32, Boundary::free);
  DrivenChain driven(chain, {.frequency_hz = 2.0, .amplitude = 0.004, .offset = 0, .ramp_s = 0},
                     DrivenChain::Start::rest);
  const double rate = slowest_decay_rate(chain);
  const auto steady = steady_response(chain, 4 * pi, 0.004);
  const double t = 40.0 / rate;
  for (std::size_t k = 0; k <= 32; ++k)
    EXPECT_NEAR(driven.at(t).y[k], (steady.Y[k] * std::polar(1.0, 4 * pi * t)).imag(), 1e-12);
}

}  // namespace
}  // namespace dwell
