#include "core/motion/motion_estimate.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <stop_token>
#include <string>

#include "core/model/forward.hpp"
#include "core/motion/given_table.hpp"
#include "core/motion/motion_fit.hpp"
#include "core/motion/table_activity.hpp"
#include "core/rig/transducer.hpp"
#include "tests/core/faulty_motion.hpp"
#include "tests/core/motion_case.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell {
namespace {

MotionData start_up(const Rig& rig, const Chain& chain, const Drive& drive, double seconds, double rate_hz,
                    double noise, std::uint64_t seed) {
  DrivenChain driven(chain, drive, DrivenChain::Start::rest);
  return readings_of(rig, driven, 0.0, seconds, rate_hz, part_of_steady(rig, chain, drive, noise), seed, 2e-4);
}

constexpr int kDraws = draws(24, 4);

TEST(MotionEstimate, FindsTheCoefficientsOfStartUpsWithTheirUncertainty) {
  std::mt19937_64 rng(12);
  double squares = 0.0, count = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Chain chain = random_chain(rng, 1 + draw % 2, draw % 4 < 2 ? Boundary::free : Boundary::clamped, 4.0);
    const Rig rig = rig_of(chain, 4.0);
    const MotionEstimate found =
        estimate_motion(rig, start_up(rig, chain, {4.0, 0.005, 0.001, draw % 3 * 0.5}, 2.0, 200.0, 0.003, rng()));
    ASSERT_EQ(found.reason, "") << draw;
    for (std::size_t e = 0; e < found.elements.size(); ++e) {
      ASSERT_TRUE(found.elements[e].identifiable) << draw << found.elements[e].reason;
      EXPECT_LT(found.elements[e].stiffness.U95, 0.1 * chain.stiffness[e]);
      for (const auto& [seen, truth] : {std::pair{found.elements[e].stiffness, chain.stiffness[e]},
                                        std::pair{found.elements[e].damping, chain.damping[e]}}) {
        EXPECT_LT(std::abs(seen.value - truth), 4 * seen.u) << draw;
        squares += std::pow((seen.value - truth) / seen.u, 2);
        ++count;
      }
    }
  }
  EXPECT_NEAR(squares / count, 1.0, 0.5 * std::sqrt(84 / count));  // three times √(2/84), as not all are independent
}

// ζ = 0.2 %: the transient takes 100 s to fall to 0.5 %.
TEST(MotionEstimate, NeedsSecondsWhereTheHarmonicVerdictNeedsMinutes) {
  const Chain chain{Boundary::free, {10.0}, {10.0 * std::pow(kTwoPi * 4.4, 2)}, {2 * 0.002 * 10.0 * kTwoPi * 4.4}};
  const Rig rig = rig_of(chain, 4.0);
  const Drive drive{4.0, 0.002, 0.0, 0.0};
  Bench bench(chain, rig, drive, DrivenChain::Start::rest, {200.0, 0.0, 0.0, {2e-5, 2e-5}, false}, 3);
  bench.run(60.0);
  EXPECT_FALSE(std::isfinite(bench.pipeline.current().settled_s));
  DrivenChain driven(chain, drive, DrivenChain::Start::rest);
  const MotionEstimate found = estimate_motion(rig, readings_of(rig, driven, 0.0, 5.0, 200.0, {2e-5, 2e-5}, 3));
  ASSERT_EQ(found.reason, "");
  const ElementEstimate& element = found.elements.front();
  EXPECT_LT(element.stiffness.U95, 0.1 * chain.stiffness[0]);
  EXPECT_LT(element.damping.U95, 0.1 * chain.damping[0]);
  EXPECT_LT(std::abs(element.stiffness.value - chain.stiffness[0]), 4 * element.stiffness.u);
  EXPECT_LT(std::abs(element.damping.value - chain.damping[0]), 4 * element.damping.u);
}

TEST(MotionEstimate, CoversAScaleAndAMassThatAreOffAsStated) {
  const Chain chain = clamped_chain();
  Rig rig = rig_of(chain, 4.0);
  rig.channels[3].scale_u = 0.01;
  rig.mass_u = {0.1, 0.1};
  MotionData data = start_up(rig, chain, {4.0, 0.005, 0.0, 0.2}, 2.0, 200.0, 0.002, 5);
  for (MotionReading& reading : data.readings)
    if (reading.channel == 3) reading.value *= 1.015;
  rig.masses[0] += 0.15;
  const MotionEstimate found = estimate_motion(rig, data);
  ASSERT_EQ(found.reason, "");
  bool scale = false, mass = false;
  for (std::size_t e = 0; e < 3; ++e) {
    const Coefficient& c = found.elements[e].stiffness;
    EXPECT_LT(std::abs(c.value - chain.stiffness[e]), 3 * c.u) << e;
    EXPECT_LT(found.u_of_noise[2 * e], 0.5 * c.u) << e;
    double shares = 0.0;
    for (const BudgetShare& share : found.elements[e].budget) {
      shares += share.stiffness_share;
      scale = scale ||
              (share.source == "scale of reaction" && share.kind == SourceKind::scale && share.channel == "reaction");
      mass = mass || (share.source == "mass 2" && share.kind == SourceKind::mass && share.mass == 2);
    }
    EXPECT_NEAR(shares, 1.0, 1e-9);
  }
  EXPECT_TRUE(scale);
  EXPECT_TRUE(mass);
}

// The search from low intensities takes what the table does beside its drive for noise. It refused every fourth such
// rig; of 300, it showed one a coefficient 74 u off.
TEST(MotionEstimate, ShowsNoWrongNumberOfATableOfManyTonesThatIsReadAFewTimesAPeriod) {
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> uniform;
  int given = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Chain chain = random_chain(rng, 1, draw % 2 == 0 ? Boundary::free : Boundary::clamped, 4.0);
    const Rig rig = rig_of(chain, 4.0);
    std::vector<FaultyMotion::Tone> tones;
    for (int i = 0; i < 8; ++i) tones.push_back({1.2 * std::pow(6.0, uniform(rng)), 0.15 + 0.5 * uniform(rng)});
    const double noise = 0.012 * 0.005;
    const MotionEstimate found =
        estimate_motion(rig, readings_of(rig, FaultyMotion(chain, {}, 0.005, tones), 5.0, 20.0 + 12.0 * uniform(rng),
                                         {noise, noise, noise * chain.stiffness.back()}, rng()));
    EXPECT_TRUE(found.missing.empty()) << draw << ": " << found.reason;
    if (found.reason.find("whether the table moves cannot be told") == 0) continue;  // hardly more than noise
    EXPECT_EQ(found.reason, "") << draw;
    ++given;
    for (std::size_t e = 0; e < found.elements.size(); ++e) {
      const ElementEstimate& element = found.elements[e];
      if (!element.identifiable) continue;
      EXPECT_LT(std::abs(element.stiffness.value - chain.stiffness[e]), 5 * element.stiffness.u) << draw << " c " << e;
      EXPECT_LT(std::abs(element.damping.value - chain.damping[e]), 5 * element.damping.u) << draw << " r " << e;
    }
  }
  EXPECT_GT(given, kDraws / 2);
}

TEST(MotionEstimate, RefusesAnElementThatIsFarFromLinear) {
  const Chain chain{Boundary::clamped, {}, {20000.0}, {300.0}};
  const Rig rig = rig_of(chain, 4.0);
  DrivenChain driven(chain, {4.0, 0.005, 0.0, 0.5}, DrivenChain::Start::rest);
  MotionData data = readings_of(rig, driven, 0.0, 3.0, 200.0, {1e-5, 0.1}, 5);
  for (MotionReading& reading : data.readings)
    if (reading.channel == 1) reading.value += 60.0 * std::tanh(200.0 * driven.at(to_s(reading.t_ns)).velocity[0]);
  const MotionEstimate found = estimate_motion(rig, data);
  EXPECT_NE(found.reason.find("no linear chain explains reaction"), std::string::npos) << found.reason;
  EXPECT_TRUE(found.elements.empty());
}

// Without masses a reversed load cell alone turns both coefficients, and the readings fit as well as before.
TEST(MotionEstimate, SaysThatAStiffnessCameOutBelowZero) {
  const Chain chain{Boundary::clamped, {}, {20000.0}, {300.0}};
  const Rig rig = rig_of(chain, 4.0);
  MotionData data = start_up(rig, chain, {4.0, 0.005, 0.0, 0.5}, 3.0, 200.0, 0.002, 5);
  for (MotionReading& reading : data.readings)
    if (reading.channel == 1) reading.value = -reading.value;
  const MotionEstimate found = estimate_motion(rig, data, {.missing = false});
  ASSERT_EQ(found.reason, "");
  EXPECT_FALSE(found.elements.front().identifiable);
  EXPECT_TRUE(found.elements.front().reason.starts_with("its stiffness came out below zero"))
      << found.elements.front().reason;
  const MotionEstimate first = estimate_motion(rig, data, {.anew = false});
  EXPECT_EQ(first.anew, AnewSearch::put_off);
  EXPECT_NE(std::find(first.warnings.begin(), first.warnings.end(),
                      "a coefficient came out below zero; what explains it is looked for with the next estimate"),
            first.warnings.end());
}

TEST(MotionEstimate, CountsTheFrequencyOfTheDriveAsASourceOfNoChannel) {
  const Chain chain = free_chain();
  const Rig rig = rig_of(chain, 4.0);
  const MotionEstimate found = estimate_motion(rig, start_up(rig, chain, {4.0, 0.005, 0.0, 0.3}, 2.0, 200.0, 0.003, 3));
  ASSERT_EQ(found.reason, "");
  const std::vector<BudgetShare>& budget = found.elements.front().budget;
  const auto drive = std::find_if(budget.begin(), budget.end(),
                                  [](const BudgetShare& share) { return share.source == "frequency of the drive"; });
  ASSERT_NE(drive, budget.end());
  EXPECT_EQ(drive->kind, SourceKind::frequency);
  EXPECT_EQ(drive->channel, "");
}

// Friction of 0.7 N beside noise of 0.5 N. Sixteen periods are needed to see how the scores of blocks scatter.
TEST(MotionEstimate, SaysWhereTooFewReadingsTellHowMuchWiderTheUncertaintyShouldBe) {
  const Chain chain{Boundary::clamped, {}, {20000.0}, {300.0}};
  const Rig rig = rig_of(chain, 4.0);
  DrivenChain driven(chain, {4.0, 0.005, 0.0, 0.5}, DrivenChain::Start::rest);
  for (const std::uint64_t seed : {1UL, 2UL}) {
    MotionData data = readings_of(rig, driven, 0.0, 2.0, 200.0, {1e-5, 0.5}, seed);
    for (MotionReading& reading : data.readings)
      if (reading.channel == 1) reading.value += 0.7 * std::tanh(200.0 * driven.at(to_s(reading.t_ns)).velocity[0]);
    const MotionEstimate found = estimate_motion(rig, data, {.missing = false});
    ASSERT_EQ(found.warnings.size(), 1u) << found.reason;
    EXPECT_EQ(found.warnings.front(),
              "the residuals of reaction are not white: the readings are too few to say how much wider the "
              "uncertainties should be");
  }
}

// What is left over of a wrong model is no noise: no coefficients, however narrow the likelihood would make them.
TEST(MotionEstimate, GivesNoCoefficientsWhereTheChainIsAnother) {
  const Chain chain = free_chain();
  DrivenChain driven(chain, {4.0, 0.005, 0.0, 0.5}, DrivenChain::Start::rest);
  Rig rig = rig_of(chain, 4.0);
  const MotionData data = readings_of(rig, driven, 0.0, 6.0, 200.0, {5e-6, 5e-6, 5e-6}, 5);
  EXPECT_EQ(estimate_motion(rig, data, {.missing = false}).reason, "");
  rig.masses.back() *= 1.2;
  rig.masses.front() *= 0.8;
  MotionData late = data;
  for (MotionReading& reading : late.readings)
    if (reading.channel == 2) reading.value *= 1.05;
  const MotionEstimate found = estimate_motion(rig, late, {.missing = false});
  EXPECT_NE(found.reason.find("the chain of the rig file does not explain"), std::string::npos) << found.reason;
  EXPECT_TRUE(found.elements.empty());
  EXPECT_EQ(found.anew, AnewSearch::not_asked);
  const MotionEstimate first = estimate_motion(rig, late, {.anew = false});
  EXPECT_NE(first.reason.find("what explains it is looked for with the next estimate"), std::string::npos)
      << first.reason;
  EXPECT_EQ(first.anew, AnewSearch::put_off);
}

TEST(MotionEstimate, IsGivenUpWhenNobodyWantsItAnyMore) {
  const Chain chain = free_chain();
  const Rig rig = rig_of(chain, 4.0);
  const MotionData data = start_up(rig, chain, {4.0, 0.005, 0.0, 0.3}, 2.0, 200.0, 0.003, 3);
  std::stop_source unwanted;
  unwanted.request_stop();
  EXPECT_THROW((void)estimate_motion(rig, data, {.stop = unwanted.get_token()}), Stopped);
}

// What a device that was absent for half a second leaves: the readings on both sides tell of one chain.
TEST(MotionEstimate, GivesTheCoefficientsBesideAGapOfTwoPeriods) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4.0);
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    DrivenChain driven(chain, {4.0, 0.005, 0.0, 0.3}, DrivenChain::Start::rest);
    MotionData data = readings_of(rig, driven, 0.0, 2.5, 200.0, {1e-5, 1e-5, 1e-5, 0.1}, seed);
    std::erase_if(data.readings, [](const MotionReading& r) { return r.t_ns > to_ns(1.1) && r.t_ns < to_ns(1.6); });
    const MotionEstimate found = estimate_motion(rig, data, {.missing = false});
    ASSERT_EQ(found.reason, "") << seed;
    for (const ElementEstimate& element : found.elements) {
      const double c = chain.stiffness[static_cast<std::size_t>(element.k - 1)];
      EXPECT_LT(std::abs(element.stiffness.value - c), 4 * element.stiffness.u) << seed << ", element " << element.k;
    }
  }
}

TEST(MotionEstimate, SaysWhyThereIsNone) {
  Rig rig = rig_of(free_chain(), 4.0);
  rig.excitation.minimum = 1e-4;
  EXPECT_EQ(estimate_motion(rig, {}).reason, "there are no readings");
  DrivenChain still(free_chain(), {4.0, 0.0, 0.0, 0.0}, DrivenChain::Start::rest);
  EXPECT_EQ(estimate_motion(rig, readings_of(rig, still, 0, 2, 200, {1e-5, 1e-5, 1e-5}, 1)).reason,
            "the table does not move");
  rig.excitation.minimum = 1e-6;
  const std::string noisy = estimate_motion(rig, readings_of(rig, still, 0, 2, 200, {1e-5, 1e-5, 1e-5}, 1)).reason;
  EXPECT_EQ(noisy.find("whether the table moves cannot be told: y0 scatters from reading to reading by "), 0U) << noisy;
  DrivenChain moving(free_chain(), {4.0, 0.005, 0.0, 0.0}, DrivenChain::Start::rest);
  EXPECT_EQ(estimate_motion(rig, readings_of(rig, moving, 0, 0.05, 200, {1e-5, 1e-5, 1e-5}, 1)).reason,
            "too few readings: 30");
}

// A wild reading is left out, not believed.
TEST(MotionEstimate, LeavesOutAReadingFarFromAll) {
  const Chain chain = free_chain();
  const Rig rig = rig_of(chain, 4.0);
  MotionData data = start_up(rig, chain, {4.0, 0.005, 0.0, 0.3}, 2.0, 200.0, 0.002, 5);
  data.readings[601].value += 0.5;
  const MotionEstimate found = estimate_motion(rig, data);
  ASSERT_EQ(found.reason, "");
  EXPECT_EQ(found.readings + 1, data.readings.size());
  for (std::size_t e = 0; e < 2; ++e)
    EXPECT_LT(std::abs(found.elements[e].stiffness.value - chain.stiffness[e]), 4 * found.elements[e].stiffness.u);
}

double squares_of(const std::vector<std::vector<MotionInnovation>>& innovations) {
  double sum = 0.0;
  for (const auto& channel : innovations)
    for (const MotionInnovation& one : channel) sum += one.normalized * one.normalized;
  return sum;
}

// p(chain, table) = p(table) p(chain | table), to the squares in the exponents.
TEST(GivenTable, IsWhatTheTableAloneLeavesOfTheWholeLikelihood) {
  for (const Rig& rig : {rig_of(free_chain(), 4.0), rig_of_all_kinds()}) {
    const Chain chain = rig.boundary == Boundary::free ? free_chain() : clamped_chain();
    DrivenChain driven(chain, {4.0, 0.005, 0.0, 0.5}, DrivenChain::Start::steady);
    std::vector<double> sigma(rig.channels.size(), 2e-4);
    MotionData data = readings_of(rig, driven, 0.0, 1.0, 150.0, sigma, 3, 0.0007);
    const auto of_table = [&rig](const MotionReading& reading) {
      return shows_drive(rig.channels[static_cast<std::size_t>(reading.channel)]);
    };
    // The table alone begins at the same instant as all.
    data.readings.erase(data.readings.begin(), std::find_if(data.readings.begin(), data.readings.end(), of_table));
    MotionData table;
    std::copy_if(data.readings.begin(), data.readings.end(), std::back_inserter(table.readings), of_table);
    const std::vector<Parameter> parameters = free_parameters(rig, 1);
    const MotionModel model(rig, parameters);
    const MotionUnknowns unknowns{theta_of(parameters, chain, sigma, -18.0),
                                  state_of(model, driven.at(to_s(data.readings.front().t_ns))),
                                  Eigen::VectorXd::Zero(static_cast<Eigen::Index>(rig.channels.size()))};
    const PassOptions keep{.derivatives = false, .keep_innovations = true};
    const double whole = squares_of(evaluate(model, data, unknowns, keep).innovations);
    const double alone = squares_of(evaluate(model, table, unknowns, keep).innovations);
    EXPECT_NEAR(squares_of(innovations_given_table(model, data, unknowns)), whole - alone, 1e-6 * whole);
  }
}

// A table that moves in harmonics which its process does not have: what is left over is the table's, not the chain's.
TEST(MotionEstimate, ConvictsNoChainOfATableThatMovesOtherwise) {
  const Chain chain = free_chain();
  const Rig rig = rig_of(chain, 4.0);
  const Drive drive{4.0, 0.005, 0.0, 0.3, {{2, 0.0005, 0.4}}};
  const MotionEstimate found = estimate_motion(rig, start_up(rig, chain, drive, 3.0, 150.0, 2e-3, 7));
  ASSERT_EQ(found.reason, "");
  for (std::size_t e = 0; e < 2; ++e) {
    EXPECT_LT(std::abs(found.elements[e].stiffness.value - chain.stiffness[e]), 4 * found.elements[e].stiffness.u);
    EXPECT_LT(std::abs(found.elements[e].damping.value - chain.damping[e]), 4 * found.elements[e].damping.u);
    EXPECT_LT(found.elements[e].stiffness.U95, 0.02 * chain.stiffness[e]);
  }
}

// Of readings that jump, here by wrapping, the cubic through their neighbours leaves over as much as of noise alone.
TEST(MotionEstimate, DoesNotSayThatATableRestsWhoseReadingsJump) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4.0);
  const Drive drive{4.0, 0.005, 0.0, 0.0};
  DrivenChain steady(chain, drive, DrivenChain::Start::steady);
  MotionData data = readings_of(rig, steady, 0.0, 4.0, 66.0, part_of_steady(rig, chain, drive, 1e-3), 3);
  for (MotionReading& reading : data.readings)
    if (reading.channel == 0) reading.value = std::remainder(reading.value, 0.007);
  const std::string reason = estimate_motion(rig, data).reason;
  EXPECT_EQ(reason.find("whether the table moves cannot be told: y0 scatters from reading to reading by "), 0U)
      << reason;
  EXPECT_NE(reason.find(" of its amplitude, and noise alone does so by 25 % or more. If it moves, check y0 or read it "
                        "more often; if not, raise excitation.minimum"),
            std::string::npos)
      << reason;
}

// Stamps of the table's transducer rounded down to 0.3 rad of the drive, by which eight readings each have one.
TEST(MotionEstimate, TakesReadingsOfOneInstantForNoNoise) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4.0);
  const Drive drive{4.0, 0.005, 0.0, 0.0};
  DrivenChain steady(chain, drive, DrivenChain::Start::steady);
  MotionData data = readings_of(rig, steady, 0.0, 3.0, 640.0, part_of_steady(rig, chain, drive, 0.005), 3);
  for (MotionReading& reading : data.readings)
    if (reading.channel == 0) reading.t_ns -= reading.t_ns % to_ns(1.0 / 80.0);
  std::stable_sort(data.readings.begin(), data.readings.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  const MotionEstimate found = estimate_motion(rig, data, {.missing = false});
  EXPECT_EQ(found.reason.find("whether the table moves"), std::string::npos) << found.reason;
  EXPECT_LT(local_noise(rig, data)[0], 0.05 * 0.005);
}

TEST(MotionEstimate, ComesToAnEndWhateverTheSizeOfTheReadings) {
  const Chain chain = clamped_chain();
  const Rig rig = rig_of(chain, 4.0);
  for (const double factor : {1e150, 1e-150}) {
    MotionData data = start_up(rig, chain, {4.0, 0.005, 0.0, 0.2}, 1.0, 200.0, 0.002, 5);
    for (MotionReading& reading : data.readings) reading.value *= factor;
    const MotionEstimate found = estimate_motion(rig, data);
    if (!found.reason.empty()) continue;
    for (std::size_t e = 0; e < found.elements.size(); ++e)
      EXPECT_NEAR(found.elements[e].stiffness.value, chain.stiffness[e], 5 * found.elements[e].stiffness.u) << factor;
  }
}

// A stiff element whose mode is below the noise: the likelihood has a peak at next to no damping, many u off.
TEST(MotionEstimate, WithholdsAnElementWhoseDampingIsNotToldFromZero) {
  const Chain chain{Boundary::free, {4.0, 3.0, 2.0}, {24e3, 8e3, 56e3}, {60.0, 45.0, 40.0}};
  const Rig rig = rig_of(chain, 4.0);
  int given = 0;
  for (std::uint64_t seed = 1; seed <= (kDraws < 24 ? 1 : 6); ++seed) {
    const MotionEstimate found =
        estimate_motion(rig, start_up(rig, chain, {4.0, 0.005, 0.0, 0.0}, 4.0, 200.0, 0.01, seed), {.missing = false});
    for (std::size_t e = 0; e < found.elements.size(); ++e) {
      if (!found.elements[e].identifiable) continue;
      ++given;
      EXPECT_GT(found.elements[e].damping.value, found.elements[e].damping.U95);
      EXPECT_LT(std::abs(found.elements[e].stiffness.value - chain.stiffness[e]), 5 * found.elements[e].stiffness.u);
      EXPECT_LT(std::abs(found.elements[e].damping.value - chain.damping[e]), 5 * found.elements[e].damping.u);
    }
  }
  EXPECT_GT(given, 0);
}

}  // namespace
}  // namespace dwell
