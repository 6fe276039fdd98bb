#include "core/chain/linearity.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "core/chain/identify.hpp"
#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

constexpr double kLinearityOmega = 2 * M_PI * 4;
constexpr int kFitted = 3;

// What an element feels beside c d + r d', N, by deformation and its rate.
using Beside = std::function<double(double d, double rate)>;

Beside friction(double newtons) {
  // Steep enough for a square wave, smooth enough for the integration.
  return [=](double, double rate) { return newtons * std::tanh(rate / 2e-4); };
}
Beside cubic(double c3) {
  return [=](double d, double) { return c3 * d * d * d; };
}
Beside quadratic(double r2) {
  return [=](double, double rate) { return r2 * rate * std::abs(rate); };
}
// A spring that is stiffer by this where the deformation is positive.
Beside one_way(double more) {
  return [=](double d, double) { return d > 0 ? more * d : 0.0; };
}
Beside nothing() {
  return [](double, double) { return 0.0; };
}

double table_at(double t, double distortion, bool rate) {
  const double A = 0.002, phase = kLinearityOmega * t;
  return rate ? A * kLinearityOmega *
                    (std::cos(phase) + 2 * distortion * std::cos(2 * phase + 0.4) +
                     3 * distortion * std::cos(3 * phase + 0.7))
              : A * (std::sin(phase) + distortion * (std::sin(2 * phase + 0.4) + std::sin(3 * phase + 0.7)));
}

// The harmonics of what the transducers of rig_of(chain) read in the steady motion, element k of them with `beside`;
// the shaker's second and third are `distortion` of its first. Runge-Kutta, the transient decayed.
std::vector<Evidence> simulated(const Chain& chain, int k, const Beside& beside, double distortion = 0.0) {
  const int n = chain.mass_count(), elements = chain.element_count();
  const auto force_in = [&](int e, const std::vector<double>& y, const std::vector<double>& v) {
    const double right = e < n ? y[static_cast<std::size_t>(e + 1)] : 0.0;
    const double right_v = e < n ? v[static_cast<std::size_t>(e + 1)] : 0.0;
    // Element n + 1 is what mass n moves against the ground.
    const double d = e < n ? right - y[static_cast<std::size_t>(e)] : y[static_cast<std::size_t>(n)];
    const double rate = e < n ? right_v - v[static_cast<std::size_t>(e)] : v[static_cast<std::size_t>(n)];
    const auto i = static_cast<std::size_t>(e);
    return chain.stiffness[i] * d + chain.damping[i] * rate + (e + 1 == k ? beside(d, rate) : 0.0);
  };
  using State = std::vector<double>;  // y_1 … y_n, their rates
  const auto whole = [&](double t, const State& s, State& y, State& v) {
    y.assign(1, table_at(t, distortion, false));
    v.assign(1, table_at(t, distortion, true));
    y.insert(y.end(), s.begin(), s.begin() + n);
    v.insert(v.end(), s.begin() + n, s.end());
  };
  State y, v;
  const auto slope = [&](double t, const State& s) {
    whole(t, s, y, v);
    State out(s.begin() + n, s.end());
    for (int m = 0; m < n; ++m) {
      const double pull = force_in(m, y, v), push = m + 1 < elements ? force_in(m + 1, y, v) : 0.0;
      // Beyond mass n a clamped chain has element n + 1, which is pulled as d = y_n says.
      const double sign = m + 1 < n ? 1.0 : -1.0;
      out.push_back((-pull + sign * push) / chain.masses[static_cast<std::size_t>(m)]);
    }
    return out;
  };
  const int per_period = 4000, periods = n > 0 ? 60 : 1;
  const double dt = 2 * M_PI / kLinearityOmega / per_period;
  State s(static_cast<std::size_t>(2 * n), 0.0);
  std::vector<std::vector<Complex>> X(static_cast<std::size_t>(n + 2), std::vector<Complex>(kFitted));
  for (int i = 0; i < per_period * periods; ++i) {
    const double t = i * dt;
    if (i >= per_period * (periods - 1)) {
      whole(t, s, y, v);
      State readings = y;
      readings.push_back(force_in(elements - 1, y, v));
      for (std::size_t c = 0; c < readings.size(); ++c)
        for (int h = 1; h <= kFitted; ++h)  // Y with y = Im(Y exp(jωt))
          X[c][static_cast<std::size_t>(h - 1)] +=
              readings[c] * 2.0 / per_period * Complex{0, 1} * std::polar(1.0, -h * kLinearityOmega * t);
    }
    const auto at = [&](const State& k1, double part) {
      State out = s;
      for (std::size_t j = 0; j < s.size(); ++j) out[j] += part * dt * k1[j];
      return out;
    };
    const State k1 = slope(t, s), k2 = slope(t + dt / 2, at(k1, 0.5)), k3 = slope(t + dt / 2, at(k2, 0.5)),
                k4 = slope(t + dt, at(k3, 1));
    for (std::size_t j = 0; j < s.size(); ++j) s[j] += dt / 6 * (k1[j] + 2 * k2[j] + 2 * k3[j] + k4[j]);
  }
  const bool clamped = chain.boundary == Boundary::clamped;
  std::vector<Evidence> out(static_cast<std::size_t>(n + 1 + (clamped ? 1 : 0)));
  for (std::size_t c = 0; c < out.size(); ++c) {
    out[c].usable = true;
    out[c].dof = 2000;
    for (int h = 1; h <= kFitted; ++h)
      out[c].X[static_cast<std::size_t>(h - 1)] = X[c][static_cast<std::size_t>(h - 1)];
  }
  return out;
}

void set_noise(std::vector<Evidence>& evidence, double part) {
  for (Evidence& one : evidence) one.covariance = Eigen::Matrix2d::Identity() * std::norm(part * one.X[0]);
}

ElementsResult estimate(const Rig& rig, const std::vector<Evidence>& evidence) {
  const Gain gain = solve_observation(observation_matrix(rig), observation_weights(rig, evidence, kLinearityOmega));
  return estimate_elements(rig, gain, evidence, {kLinearityOmega, 0, 0});
}

std::string all(const std::vector<Warning>& warnings) {
  std::string text;
  for (const Warning& warning : warnings) text += warning.what + "\n";
  return text;
}

bool says(const ElementsResult& result, const std::string& what) {
  return all(result.warnings).find(what) != std::string::npos;
}

std::string doubts_of(const ElementsResult& result) {
  std::string text;
  for (const Doubt& doubt : result.doubts) text += doubt.what + "\n";
  return text;
}

// 10 N of friction beside a force of 120 N: r three times too large, harmonic 3 of the force 3.5 % of the fundamental.
TEST(Linearity, FrictionIsHeldAgainstTheDissipativeForceNotAgainstTheWhole) {
  const Chain chain{Boundary::clamped, {}, {60000}, {60}};
  const Rig rig = rig_of(chain, 4);
  std::vector<Evidence> evidence = simulated(chain, 1, friction(10));
  set_noise(evidence, 1e-4);
  const ElementsResult result = estimate(rig, evidence);
  EXPECT_GT(result.elements[0].damping.value, 3 * chain.damping[0]);
  ASSERT_EQ(result.warnings.size(), 1u) << all(result.warnings);
  for (const char* named : {"element 1", "equivalent damping at this amplitude", "damping force 15.7 N",
                            "Friction of about 10 N", " % of r"})
    EXPECT_TRUE(says(result, named)) << all(result.warnings);
  EXPECT_EQ(result.warnings[0].kind, WarningKind::nonlinear);
  EXPECT_EQ(result.warnings[0].elements, std::vector<int>{1});
}

TEST(Linearity, OfAChainTheElementThatRubsIsNamedAndNoOther) {
  for (int k = 1; k <= 3; ++k) {
    const Rig rig = rig_of(clamped_chain(), 4);
    std::vector<Evidence> evidence = simulated(clamped_chain(), k, friction(2));
    set_noise(evidence, 1e-5);
    const ElementsResult result = estimate(rig, evidence);
    ASSERT_EQ(result.warnings.size(), 1u) << all(result.warnings);
    EXPECT_TRUE(says(result, "element " + std::to_string(k) + " is ")) << all(result.warnings);
    EXPECT_TRUE(says(result, "Friction of ")) << all(result.warnings);
  }
}

// Element 2 of clamped_chain() hardens by a twentieth at its amplitude; noise 1e-5.
std::vector<Evidence> hardening() {
  const Chain chain = clamped_chain();
  const double a = estimate(rig_of(chain, 4), simulated(chain, 2, nothing())).elements[1].deformation.value;
  std::vector<Evidence> evidence = simulated(chain, 2, cubic(0.05 * chain.stiffness[1] / (a * a)));
  set_noise(evidence, 1e-5);
  return evidence;
}

TEST(Linearity, ACubicSpringHasAnEquivalentStiffness) {
  const ElementsResult result = estimate(rig_of(clamped_chain(), 4), hardening());
  ASSERT_EQ(result.warnings.size(), 1u) << all(result.warnings);
  for (const char* named : {"element 2", "equivalent stiffness", "at this amplitude", "hardens", " % of c"})
    EXPECT_TRUE(says(result, named)) << all(result.warnings);
}

// A beat that is left in the fundamental widens c and r, and says nothing of harmonic 3.
TEST(Linearity, IsNotHiddenByAScatterOfTheFundamental) {
  std::vector<Evidence> evidence = hardening();
  for (Evidence& one : evidence) one.widened = 1e4;
  EXPECT_TRUE(says(estimate(rig_of(clamped_chain(), 4), evidence), "element 2"));
}

// A transducer that compresses, y - βy³: its third harmonic has the phase of its reading.
void compress(Evidence& channel, double third) {
  const double phase = std::arg(channel.X[0]);
  channel.X[2] += third * std::abs(channel.X[0]) * std::polar(1.0, 3 * phase);
  channel.X[0] *= 1 - 3 * third;
}

// The elements are not nonlinear with equivalent coefficients: their coefficients are wrong.
TEST(Linearity, WhereATransducerThatCompressesExplainsSeveralElementsTheyAreDoubted) {
  const Rig rig = rig_of(clamped_chain(), 4);
  for (const std::size_t c : {1U, 2U, 3U})
    for (const double third : {0.001, 0.01, -0.01}) {
      std::vector<Evidence> evidence = simulated(clamped_chain(), 1, nothing(), 0.02);
      compress(evidence[c], third);
      set_noise(evidence, 1e-5);
      const ElementsResult result = estimate(rig, evidence);
      const std::string doubts = doubts_of(result);
      EXPECT_NE(doubts.find(rig.channels[c].name + " distorts"), std::string::npos) << doubts;
      EXPECT_NE(doubts.find(third > 0 ? " too small" : " too large"), std::string::npos) << doubts;
      for (const Warning& warning : result.warnings)
        for (const int k : warning.elements) {
          const auto concerned = [k](const Doubt& doubt) { return concerns(doubt, k); };
          EXPECT_TRUE(std::any_of(result.doubts.begin(), result.doubts.end(), concerned)) << "element " << k;
        }
    }
}

TEST(Linearity, AnElementThatIsNotLinearBlamesNoTransducer) {
  const Rig rig = rig_of(clamped_chain(), 4);
  const Chain chain = clamped_chain();
  const double a = estimate(rig, simulated(chain, 2, nothing())).elements[1].deformation.value;
  for (int k = 1; k <= 3; ++k)
    for (const Beside& beside : {friction(2), cubic(0.05 * chain.stiffness[1] / (a * a)), quadratic(50)}) {
      std::vector<Evidence> evidence = simulated(chain, k, beside);
      set_noise(evidence, 1e-5);
      const ElementsResult result = estimate(rig, evidence);
      EXPECT_EQ(doubts_of(result), "");
      for (const Warning& warning : result.warnings) EXPECT_TRUE(warning.channels.empty()) << warning.what;
    }
}

TEST(Linearity, ASpringThatIsStifferOneWayIsToldWithItsPartOfC) {
  const Rig rig = rig_of(clamped_chain(), 4);
  const Chain chain = clamped_chain();
  for (int k = 1; k <= 3; ++k) {
    const double stiffness = chain.stiffness[static_cast<std::size_t>(k - 1)];
    std::vector<Evidence> evidence = simulated(chain, k, one_way(0.02 * stiffness));
    set_noise(evidence, 1e-5);
    const ElementsResult result = estimate(rig, evidence);
    ASSERT_EQ(result.warnings.size(), 1U) << all(result.warnings);
    EXPECT_EQ(result.warnings[0].elements, std::vector<int>{k});
    EXPECT_TRUE(says(result, "harmonic 2 of its force")) << all(result.warnings);
    EXPECT_TRUE(says(result, "A spring that is stiffer one way than the other would explain it, and 0.99 % of c"))
        << all(result.warnings);
    EXPECT_EQ(doubts_of(result), "");
  }
}

// What a transducer reads whose readings are `law` of the right ones, y = Im Σ X_h exp(jhφ).
void distort(Evidence& channel, const std::function<double(double)>& law) {
  constexpr int kSteps = 4096;
  std::vector<Complex> read(kFitted);
  for (int i = 0; i < kSteps; ++i) {
    const double phase = 2 * M_PI * i / kSteps;
    double y = 0.0;
    for (int h = 1; h <= kFitted; ++h)
      y += (channel.X[static_cast<std::size_t>(h - 1)] * std::polar(1.0, h * phase)).imag();
    for (int h = 1; h <= kFitted; ++h)
      read[static_cast<std::size_t>(h - 1)] += Complex(0.0, 2.0 / kSteps) * law(y) * std::polar(1.0, -h * phase);
  }
  std::copy(read.begin(), read.end(), channel.X.begin());
}

// Whether the fundamental errs with it is not known: a transducer with some y² adds the same and loses nothing.
TEST(Linearity, ATransducerWhoseGainDiffersBetweenTheHalvesIsNamed) {
  const Rig rig = rig_of(clamped_chain(), 4);
  for (const std::size_t c : {1U, 2U, 3U})
    for (const double more : {0.003, 0.03, -0.03}) {
      std::vector<Evidence> evidence = simulated(clamped_chain(), 1, nothing());
      distort(evidence[c], [=](double y) { return y > 0 ? (1 + more) * y : y; });
      set_noise(evidence, 1e-5);
      const ElementsResult result = estimate(rig, evidence);
      ASSERT_GT(result.warnings.size(), 1U) << all(result.warnings);
      const Warning& last = result.warnings.back();
      EXPECT_NE(std::find(last.channels.begin(), last.channels.end(), rig.channels[c].name), last.channels.end())
          << all(result.warnings);
      const std::string words = rig.channels[c].name + " distorts", wrong = "may then be wrong by ";
      const auto at = last.what.find(wrong, last.what.find(words));
      ASSERT_NE(at, std::string::npos) << last.what;
      EXPECT_NEAR(std::atof(last.what.c_str() + at + wrong.size()), 50 * std::abs(more), 5 * std::abs(more))
          << last.what;
    }
}

// Its readings of the shaker's harmonics err as well, so that no channel need be named.
TEST(Linearity, ATransducerWhoseGainDiffersBetweenTheHalvesIsNotSilentBesideAShakerThatDistorts) {
  const Rig rig = rig_of(clamped_chain(), 4);
  for (const std::size_t c : {1U, 2U, 3U})
    for (const double more : {0.003, 0.03, -0.03}) {
      std::vector<Evidence> evidence = simulated(clamped_chain(), 1, nothing(), 0.02);
      distort(evidence[c], [=](double y) { return y > 0 ? (1 + more) * y : y; });
      set_noise(evidence, 1e-5);
      const ElementsResult result = estimate(rig, evidence);
      EXPECT_TRUE(says(result, "harmonic 2 of its force")) << c << " " << more;
    }
}

TEST(Linearity, DampingThatGrowsWithTheVelocityIsNoFriction) {
  const Chain chain{Boundary::clamped, {}, {60000}, {60}};
  std::vector<Evidence> evidence = simulated(chain, 1, quadratic(200));
  set_noise(evidence, 1e-4);
  const ElementsResult result = estimate(rig_of(chain, 4), evidence);
  EXPECT_TRUE(says(result, "square of the velocity")) << all(result.warnings);
  EXPECT_FALSE(says(result, "Friction")) << all(result.warnings);
}

TEST(Linearity, TheShakersOwnHarmonicsAreNoneOfALinearElement) {
  for (const double distortion : {0.01, 0.1, 0.5}) {
    std::vector<Evidence> evidence = simulated(clamped_chain(), 1, nothing(), distortion);
    set_noise(evidence, 1e-5);
    const ElementsResult result = estimate(rig_of(clamped_chain(), 4), evidence);
    EXPECT_TRUE(result.warnings.empty()) << distortion << ": " << all(result.warnings);
  }
}

// Noise, and errors of all that the rig file states, on a linear rig with a shaker that distorts.
TEST(Linearity, NoFalseAlarmInThousandsOfHealthyDwells) {
  Rig rig = rig_of(clamped_chain(), 4);
  rig.mass_u = {0.06, 0.04};
  for (Channel& channel : rig.channels) channel.scale_u = 5e-3, channel.delay_u_s = 3e-5;
  std::mt19937_64 rng(41);
  std::normal_distribution<double> normal;
  for (const double noise : {1e-5, 1e-3}) {
    std::vector<Evidence> exact = simulated(clamped_chain(), 1, nothing(), 0.05);
    set_noise(exact, noise);
    int alarms = 0;
    for (int dwell = 0; dwell < 3000; ++dwell) {
      Rig stated = rig;
      for (std::size_t i = 0; i < stated.masses.size(); ++i) stated.masses[i] += rig.mass_u[i] * normal(rng);
      std::vector<Evidence> seen = exact;
      for (std::size_t c = 0; c < seen.size(); ++c) {
        const double gain = 1 + rig.channels[c].scale_u * normal(rng), late = rig.channels[c].delay_u_s * normal(rng);
        const double sigma = std::sqrt(exact[c].covariance(0, 0));
        for (int h = 1; h <= kFitted; ++h) {
          Complex& X = seen[c].X[static_cast<std::size_t>(h - 1)];
          X = X * gain * std::polar(1.0, -h * kLinearityOmega * late) +
              Complex{sigma * normal(rng), sigma * normal(rng)};
        }
      }
      alarms += estimate(stated, seen).warnings.empty() ? 0 : 1;
    }
    EXPECT_EQ(alarms, 0) << noise;
  }
}

}  // namespace
}  // namespace dwell
