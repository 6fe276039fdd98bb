#include "core/verify/verification_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"

namespace dwell {
namespace {

constexpr double kOmega = kTwoPi * 4.0, kSigma = 1e-5;

double steady_table(double t_s) { return 5e-3 * std::sin(kOmega * t_s + 0.3) + 1e-4 * std::sin(2 * kOmega * t_s); }

ChannelReadings noisy(const std::function<double(double)>& motion) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> noise(0.0, kSigma);
  ChannelReadings out;
  for (int i = 0; i < 1000; ++i) {
    out.t_ns.push_back(to_ns(i / 100.0));
    out.value.push_back(motion(i / 100.0) + noise(rng));
  }
  return out;
}

Eigen::MatrixXd as_row(const ChannelReadings& readings) {
  return Eigen::Map<const Eigen::RowVectorXd>(readings.value.data(), static_cast<Eigen::Index>(readings.value.size()));
}

TEST(SteadyTable, TakesTheNoiseOffASteadyTable) {
  const ChannelReadings readings = noisy(steady_table);
  const SteadyTable table(readings, kSigma, kOmega, 3);
  EXPECT_LE(table.from(), 50);
  const Eigen::MatrixXd motion = table.apply(as_row(readings));
  const auto instants = static_cast<Eigen::Index>(table.instants().size());
  EXPECT_GE(instants, 1.9 * 950);  // 25 readings a period, at least 30 are given
  double squares = 0.0;
  for (Eigen::Index i = table.from(); i < instants; ++i)
    squares += std::pow(motion(0, i) - steady_table(to_s(table.instants()[static_cast<std::size_t>(i)])), 2);
  EXPECT_LT(std::sqrt(squares / static_cast<double>(instants)), 0.2 * kSigma);  // √(7/950) = 0.086 of it is expected
}

TEST(SteadyTable, LeavesTheStartAsItWasRead) {
  const ChannelReadings readings =
      noisy([](double t_s) { return std::min(1.0, std::max(0.0, t_s - 2.0)) * steady_table(t_s); });
  const SteadyTable table(readings, kSigma, kOmega, 3);
  EXPECT_GE(table.from(), 298);
  EXPECT_LE(table.from(), 350);
  const Eigen::MatrixXd series = table.apply(as_row(readings));
  EXPECT_EQ(series.leftCols(table.from()), as_row(readings).leftCols(table.from()));
}

TEST(SteadyTable, LeavesATableThatWandersAsItWasRead) {
  const ChannelReadings readings = noisy([](double t_s) { return (1 + 0.05 * std::sin(t_s)) * steady_table(t_s); });
  EXPECT_EQ(SteadyTable(readings, kSigma, kOmega, 3).from(), 1000);
}

}  // namespace
}  // namespace dwell
