// The sources of error of a rig: which there are, and that each is what the same error of the rig file does.
#include "core/chain/error_sources.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "core/rig/transducer.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/core/steady_evidence.hpp"

namespace dwell {
namespace {

using Eigen::VectorXcd;
using Index = Eigen::Index;

// The bench at 4 Hz, its sources under what `rig` and `evidence` say.
struct SourcesOfBench {
  Rig rig = rig_of(clamped_chain(), 4);
  double omega = 2 * M_PI * 4;
  std::vector<Evidence> evidence = steady_evidence(clamped_chain(), rig, omega);

  void read_anew() { evidence = steady_evidence(clamped_chain(), rig, omega); }
  [[nodiscard]] Gain gain() const {
    return solve_observation(observation_matrix(rig), observation_weights(rig, evidence, omega));
  }
  // x as an analyst finds it who takes the readings for those of `assumed`.
  [[nodiscard]] VectorXcd x_by(const Rig& assumed) const { return gain().gain * observed_by(assumed, evidence, omega); }
  [[nodiscard]] std::map<std::string, std::vector<ErrorSource>> list(double u_omega = 0.0, double clock_u = 0.0) const {
    const Gain gain = this->gain();
    const VectorXcd o = observed_by(rig, evidence, omega);
    const ChainState chain{rig, rig.mass_count(), omega, gain.gain * o};
    std::map<std::string, std::vector<ErrorSource>> by_name;
    for (ErrorSource& source : sources_of(gain, evidence, o, chain, ElementStates(chain), {omega, u_omega, clock_u}))
      by_name[source.name].push_back(source);
    return by_name;
  }
  // The one source of that name.
  [[nodiscard]] ErrorSource only(const std::string& name, double u_omega = 0.0, double clock_u = 0.0) const {
    const auto all = list(u_omega, clock_u);
    EXPECT_EQ(all.size(), 1u);
    const auto found = all.find(name);
    if (found == all.end() || found->second.size() != 1) {
      ADD_FAILURE() << "no single source named " << name;
      return {};
    }
    EXPECT_TRUE(std::isinf(found->second[0].dof)) << "type B";
    return found->second[0];
  }
};

TEST(ErrorSources, AnExactRigHasNone) { EXPECT_TRUE(SourcesOfBench().list().empty()); }

TEST(ErrorSources, AStatedUncertaintyIsWhatTheSameErrorOfTheRigFileDoes) {
  SourcesOfBench stated;
  stated.rig.devices = {{"line", 1e-3, 0.0}};
  stated.rig.channels[1].device = stated.rig.channels[2].device = 0;
  stated.rig.channels[1].lowpass = {FilterKind::butterworth, 2, 60, 0};
  stated.rig.channels[2].highpass = {FilterKind::rc, 1, 0.5, 0};
  stated.read_anew();
  for (const auto& [name, state, off] :
       {std::tuple<const char*, std::function<void(Rig&)>, std::function<void(Rig&, double)>>{
            "delay of y1", [](Rig&rig) { rig.channels[1].delay_u_s = 1e-3; },
            [](Rig&rig, double t) { rig.channels[1].delay_s += 1e-3 * t; }},
        {"delay of line", [](Rig&rig) { rig.devices[0].delay_u_s = 2e-3; },
         [](Rig&rig, double t) { rig.devices[0].delay_s += 2e-3 * t; }},
        {"low-pass of y1", [](Rig&rig) { rig.channels[1].lowpass.hz_u = 3; },
         [](Rig&rig, double t) { rig.channels[1].lowpass.hz += 3 * t; }},
        {"high-pass of y2", [](Rig&rig) { rig.channels[2].highpass.hz_u = 0.1; },
         [](Rig&rig, double t) { rig.channels[2].highpass.hz += 0.1 * t; }}}) {
    SourcesOfBench bench = stated;
    state(bench.rig);
    const ErrorSource source = bench.only(name);
    constexpr double kPart = 1e-3;  // central differences: off by its square
    Rig above = bench.rig, below = bench.rig;
    off(above, kPart);
    off(below, -kPart);
    const VectorXcd by_file = (bench.x_by(above) - bench.x_by(below)) / (2 * kPart);
    EXPECT_LT((source.on_x - by_file).norm(), 1e-4 * by_file.norm()) << name;
    EXPECT_TRUE(source.on_Z.isZero(0)) << name;
    if (source.bends_x.size() == 0) continue;
    const VectorXcd bends = (bench.x_by(above) + bench.x_by(below) - 2 * bench.x_by(bench.rig)) / (2 * kPart * kPart);
    EXPECT_LT((source.bends_x - bends).norm(), 1e-4 * bends.norm()) << name;
  }
}

TEST(ErrorSources, AScaleIsAPartOfWhatItsChannelObserves) {
  SourcesOfBench bench;
  bench.rig.channels[3].scale_u = 0.01;
  const ErrorSource scale = bench.only("scale of reaction");
  const VectorXcd x = bench.x_by(bench.rig);
  EXPECT_LT(std::abs(scale.on_x(3) - 0.01 * x(3)), 1e-12 * std::abs(x(3)));
  EXPECT_LT(scale.on_x.head(3).norm(), 1e-12 * x.head(3).norm());
  ASSERT_EQ(scale.readings.size(), 1u);
  EXPECT_EQ(scale.readings[0].channel, 3);
  EXPECT_EQ(scale.readings[0].relative, 0.01);
}

TEST(ErrorSources, AMassMovesEveryElementBetweenItAndTheTable) {
  SourcesOfBench bench;
  bench.rig.mass_u = {0.1, 0.0};
  const ErrorSource mass = bench.only("mass 1");
  EXPECT_EQ(mass.mass, 1);
  Rig heavier = bench.rig;
  heavier.masses[0] += 0.1;
  const VectorXcd x = bench.x_by(bench.rig);
  const VectorXcd change =
      ElementStates({heavier, 2, bench.omega, x}).Z - ElementStates({bench.rig, 2, bench.omega, x}).Z;
  EXPECT_LT((mass.on_Z - change).norm(), 1e-9 * change.norm());
  EXPECT_GT(std::abs(mass.on_Z(0)), 0.0);
  EXPECT_EQ(mass.on_Z(1), 0.0);
}

TEST(ErrorSources, FrequencyAndClockActAlikeAndTheClockIsMarked) {
  SourcesOfBench bench;
  bench.rig.channels[1].measures = Quantity::velocity;
  bench.read_anew();
  const ErrorSource frequency = bench.only("frequency", 1e-3 * bench.omega),
                    clock = bench.only("clock rate", 0.0, 1e-3);
  EXPECT_LT((frequency.on_x - clock.on_x).norm(), 1e-12 * frequency.on_x.norm());
  EXPECT_LT((frequency.on_Z - clock.on_Z).norm(), 1e-12 * frequency.on_Z.norm());
  EXPECT_EQ(frequency.clock_u, 0.0);
  EXPECT_EQ(clock.clock_u, 1e-3);
  // Both together are what another ω makes of the same readings.
  const double step = 1e-3 * bench.omega * 1e-2;
  const auto x_at = [&](double omega) -> VectorXcd {
    return bench.gain().gain * observed_by(bench.rig, bench.evidence, omega);
  };
  const VectorXcd by_omega = (x_at(bench.omega + step) - x_at(bench.omega - step)) / 2e-2;
  EXPECT_LT((frequency.on_x - by_omega).norm(), 1e-6 * by_omega.norm());
  EXPECT_NEAR(frequency.on_omega, 1e-3 * bench.omega, 1e-15);
}

TEST(ErrorSources, NoiseIsTwoOfTypeAAlongItsAxes) {
  SourcesOfBench bench;
  bench.evidence[2].covariance << 4e-12, 1e-12, 1e-12, 2e-12;
  const auto all = bench.list();
  ASSERT_EQ(all.size(), 1u);
  const std::vector<ErrorSource>& noise = all.at("noise of y2");
  ASSERT_EQ(noise.size(), 2u);
  // y2 is seen in d_2 alone, x(2).
  Eigen::Matrix2d product = Eigen::Matrix2d::Zero();
  for (const ErrorSource& one : noise) {
    EXPECT_TRUE(one.residual);
    EXPECT_EQ(one.dof, 1000);
    const Eigen::Vector2d parts{one.on_x(2).real(), one.on_x(2).imag()};
    product += parts * parts.transpose();
  }
  EXPECT_LT((product - bench.evidence[2].covariance).norm(), 1e-18);
}

TEST(ErrorSources, InstantsThatATransactionSharesAreOneSourceNamedByItsChannels) {
  SourcesOfBench bench;
  bench.rig.devices = {{"line", 0.0, 0.0}};
  for (std::size_t c = 0; c < 4; ++c) {
    bench.rig.channels[c].device = 0;
    bench.evidence[c].turnaround_u_s = 1e-3;
    bench.evidence[c].transaction = c < 3 ? 0 : 3;
  }
  const auto all = bench.list();
  ASSERT_EQ(all.size(), 2u);
  const std::vector<ErrorSource>& three = all.at("turnaround of line (y0, y1, y2)");
  ASSERT_EQ(three.size(), 1u);
  EXPECT_EQ(three[0].readings.size(), 3u);
  EXPECT_EQ(all.at("turnaround of line (reaction)")[0].readings[0].late_s, 1e-3);
}

TEST(ErrorSources, EachTellsItsKindAndWhoseItIs) {
  SourcesOfBench bench;
  bench.rig.devices = {{"line", 0.0, 1e-4}};
  bench.rig.mass_u = {0.1, 0.0};
  Channel& y1 = bench.rig.channels[1];
  y1.device = 0;
  y1.scale_u = 0.01;
  y1.delay_u_s = 1e-3;
  y1.lowpass = {FilterKind::butterworth, 2, 60, 3};
  bench.read_anew();
  bench.evidence[1].turnaround_u_s = bench.evidence[1].refresh_u_s = 1e-3;
  bench.evidence[1].quantization_u = 1e-6;
  bench.evidence[1].folded_u = 1e-6;
  bench.evidence[1].covariance = bench.evidence[1].transient = 1e-12 * Eigen::Matrix2d::Identity();
  std::map<std::string, std::string> told;
  for (const auto& [name, sources] : bench.list(1e-3, 1e-6))
    told[name] = std::string(to_string(sources[0].kind)) + "|" + sources[0].channel + "|" + sources[0].device + "|" +
                 std::to_string(sources[0].mass);
  EXPECT_EQ(told, (std::map<std::string, std::string>{{"noise of y1", "noise|y1||0"},
                                                      {"transient left in y1", "transient left|y1||0"},
                                                      {"quantization of y1", "quantization|y1||0"},
                                                      {"folded harmonics of y1", "folded harmonics|y1||0"},
                                                      {"scale of y1", "scale|y1||0"},
                                                      {"refresh of y1", "refresh|y1||0"},
                                                      {"delay of y1", "delay|y1||0"},
                                                      {"low-pass of y1", "low-pass|y1||0"},
                                                      {"delay of line", "delay||line|0"},
                                                      {"turnaround of line", "turnaround||line|0"},
                                                      {"mass 1", "mass|||1"},
                                                      {"frequency", "frequency|||0"},
                                                      {"clock rate", "clock rate|||0"}}));
}

TEST(ErrorSources, AChannelThatIsNotUsedHasNone) {
  SourcesOfBench bench;
  for (std::size_t c = 0; c < 4; ++c) bench.rig.channels[c].scale_u = 0.01;
  bench.evidence[3].usable = false;
  const auto all = bench.list();
  EXPECT_EQ(all.size(), 3u);
  EXPECT_EQ(all.count("scale of reaction"), 0u);
}

TEST(ErrorSources, ASlopeOfPhasorsIsOneWhereItShows) {
  SourcesOfBench bench;
  const double u = 1e-6;
  bench.evidence[1].slope = {{u, 0.0}, u * u};
  EXPECT_TRUE(bench.list().empty());
  bench.evidence[1].slope = {{5 * u, 0.0}, u * u};
  const ErrorSource change = bench.only("change within the dwell");
  EXPECT_TRUE(change.on_x.isZero(0)) << "displacements read no slope";
  EXPECT_GT(change.on_Z.norm(), 0.0);
}

}  // namespace
}  // namespace dwell
