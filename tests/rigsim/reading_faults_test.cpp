// What devices and gateways do to readings, on the simulated device itself and in recordings.
#include "tests/rigsim/reading_faults.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "tests/rigsim/device.hpp"
#include "tests/rigsim/recording.hpp"
#include "tests/rigsim/responder.hpp"
#include "tests/rigsim/rig_fixture.hpp"

namespace rigsim {
namespace {

constexpr std::size_t kForce = 4;

Options steady(std::vector<std::string> lines) {
  Options options;
  options.from_steady = true;
  options.lines = std::move(lines);
  EXPECT_EQ(Device::fault(options), "");
  return options;
}

// One channel at 1 kHz for a second. First read half a millisecond after the beginning, it is read at no instant of a
// refresh.
std::vector<double> readings(Device& device, std::size_t channel, int station = 0, double first_s = 0.0005) {
  std::vector<double> values(device.channels().size()), of;
  for (int i = 0; i < 1000; ++i) {
    device.read(first_s + 0.001 * i, values, station);
    of.push_back(values[channel]);
  }
  return of;
}

std::size_t different(const std::vector<double>& values) {
  return std::set<double>(values.begin(), values.end()).size();
}

double largest(const std::vector<double>& values) {
  double most = 0.0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return most;
}

TEST(ReadingFaults, AChannelRefreshedSlowlyHoldsTheValueOfItsLastRefresh) {
  Options options = steady({"refresh reaction 0.005"});
  options.faults.noise = 0.001;
  Device device(options), exact(steady({}));
  const std::vector<double> force = readings(device, kForce), truth = readings(exact, kForce);
  EXPECT_EQ(different(force), 200U);
  for (std::size_t i = 0; i < force.size(); ++i)
    EXPECT_LT(std::abs(force[i] - truth[i - i % 5]), 0.02 * largest(truth));
  EXPECT_GT(different(readings(device, 0)), 900U);
}

TEST(ReadingFaults, AReadingAtTheInstantOfARefreshTakesTheValueThatIsThenHeld) {
  Options options = steady({"refresh reaction 0.005"});
  options.faults.noise = 0.001;
  Device device(options);
  const std::vector<double> force = readings(device, kForce, 0, 0.0);
  EXPECT_EQ(different(force), 200U);
}

TEST(ReadingFaults, AStationIsRefreshedByItself) {
  Options options = steady({"refresh 2 0.01"});
  options.faults.noise = 0.001;  // so that no two values are equal by themselves
  Device device(options), other(options);
  EXPECT_EQ(different(readings(device, 0, 2)), 100U);
  EXPECT_EQ(different(readings(other, 0, 1)), 1000U);
}

TEST(ReadingFaults, ClippingEndsOnEachSideWhereItIsTold) {
  Device device(steady({"clip reaction -0.5 0.9"})), exact(steady({}));
  const std::vector<double> clipped = readings(device, kForce), truth = readings(exact, kForce);
  const double amplitude = largest(truth);
  for (std::size_t i = 0; i < truth.size(); ++i)
    EXPECT_NEAR(clipped[i], std::clamp(truth[i], -0.5 * amplitude, 0.9 * amplitude), 1e-3 * amplitude);
}

TEST(ReadingFaults, AConverterHasItsStepsAndItsEndCodes) {
  Device device(steady({"converter reaction 8 0.9"})), exact(steady({}));
  const double amplitude = largest(readings(exact, kForce)), step = 0.9 * amplitude / 128;
  const std::vector<double> force = readings(device, kForce);
  const auto [low, high] = std::minmax_element(force.begin(), force.end());
  EXPECT_NEAR(*low, -128 * step, 1e-3 * amplitude);
  EXPECT_NEAR(*high, 127 * step, 1e-3 * amplitude);
  EXPECT_LE(different(force), 256U);
}

TEST(ReadingFaults, ZerosAndRepeatsOfAGatewayBefallWholeScansAndThoseOfAChannelThatAlone) {
  for (const bool all : {true, false}) {
    Device device(steady({std::string("zeros ") + (all ? "all" : "y1") + " 0.1",
                          std::string("repeats ") + (all ? "all" : "y1") + " 0.1"}));
    std::vector<double> values(device.channels().size()), before;
    int zeros = 0, repeats = 0, others = 0;
    for (int i = 0; i < 2000; ++i) {
      device.read(0.01 + 0.001 * i, values);
      zeros += values[1] == 0.0;
      repeats += !before.empty() && values[1] == before[1] && values[1] != 0.0;
      others += values[2] == 0.0 || (!before.empty() && values[2] == before[2]);
      before = values;
    }
    EXPECT_NEAR(zeros, 200, 60);
    EXPECT_NEAR(repeats, 180, 60);
    if (all) {
      EXPECT_NEAR(others, zeros + repeats, 5);
    } else {
      EXPECT_EQ(others, 0);
    }
  }
}

TEST(ReadingFaults, EverySecondReadingIsTheOneBeforeOnceMore) {
  Options options = steady({"stale reaction 2"});
  options.faults.noise = 0.001;
  Device device(options);
  const std::vector<double> force = readings(device, kForce);
  for (std::size_t i = 1; i < force.size(); ++i) EXPECT_EQ(force[i] == force[i - 1], i % 2 == 1) << i;
  EXPECT_EQ(different(readings(device, 0)), 1000U);
}

TEST(ReadingFaults, ARegisterHoldsInBursts) {
  Options options = steady({"freeze reaction 0.01 0.05"});
  options.faults.noise = 0.001;
  Device device(options);
  const std::vector<double> force = readings(device, kForce);
  std::map<std::size_t, int> runs;  // by length
  for (std::size_t i = 0, from = 0; i < force.size(); ++i)
    if (force[i] != force[from]) ++runs[i - from], from = i;
  // Some 50 readings in a burst, one reading in a hundred begins one.
  EXPECT_GT(runs[1], 250);
  EXPECT_GE(runs.rbegin()->first, 50U);
  EXPECT_LE(different(force), 850U);
  EXPECT_EQ(different(readings(device, 1)), 1000U);
}

TEST(ReadingFaults, GarbageIsAFloatInTheWrongOrderOfWords) {
  Device device(steady({"garbage y1 0.5"})), exact(steady({}));
  const std::vector<double> read = readings(device, 1), truth = readings(exact, 1);
  int garbage = 0, wild = 0;
  for (std::size_t i = 0; i < read.size(); ++i) {
    garbage += read[i] != truth[i];
    wild += std::abs(read[i]) > 1e3 || std::abs(read[i]) < 1e-12;
  }
  EXPECT_NEAR(garbage, 500, 70);
  EXPECT_GT(wild, 300);
}

TEST(ReadingFaults, TheLowByteOfAConverterIsStuck) {
  Device device(steady({"converter reaction 16 1.2", "low-byte reaction 90"})), exact(steady({}));
  const std::vector<double> force = readings(device, kForce), truth = readings(exact, kForce);
  const double step = 1.2 * largest(truth) / 32768;
  for (std::size_t i = 0; i < force.size(); ++i) {
    const double code = force[i] / step;
    EXPECT_NEAR(std::remainder(code - 90, 256), 0.0, 0.1) << i;  // `largest` is not the amplitude itself
    EXPECT_NEAR(force[i], truth[i], 257 * step);
  }
}

TEST(ReadingFaults, AGlitchIsOffTheGridOfTheRoundingAndComesOnce) {
  Device device(steady({})), same(steady({}));
  device.faults.quantize = same.faults.quantize = 0.01;
  std::vector<double> values(device.channels().size()), good(values.size());
  int off = 0;
  for (int i = 0; i < 100; ++i) {
    if (i == 50) {
      EXPECT_EQ(device.command(0.05, {"glitch", "reaction", "0.0037"}), "");
    }
    device.read(0.001 * i, values);
    same.read(0.001 * i, good);
    if (values[kForce] == good[kForce]) continue;
    ++off;
    EXPECT_EQ(i, 50);
    EXPECT_NEAR(values[kForce] - good[kForce], 0.0037 * 54.6, 1e-4 * 54.6);
  }
  EXPECT_EQ(off, 1);
}

// What a rig file may state wrongly of its channels.
TEST(ReadingFaults, AChannelIsLateOrOfAnotherScaleOrReversedOrSwapped) {
  Device late(steady({"lag y1 0.01"})), scaled(steady({"scale y1 -2.54"})), swapped(steady({"swap y1 y2"})),
      exact(steady({}));
  const std::vector<double> y1 = readings(exact, 1), y2 = readings(exact, 2);
  const std::vector<double> of_late = readings(late, 1), of_scaled = readings(scaled, 1);
  for (std::size_t i = 10; i < y1.size(); ++i) {
    EXPECT_NEAR(of_late[i], y1[i - 10], 1e-9);
    EXPECT_NEAR(of_scaled[i], -2.54 * y1[i], 1e-12);
  }
  EXPECT_EQ(readings(swapped, 1), y2);
  EXPECT_EQ(readings(swapped, 2), y1);
}

TEST(ReadingFaults, AChannelIsLateByARandomTimeOrSomeOfItsReadingsAreOfAnotherScale) {
  Device late(steady({"lag y1 0 0.01"})), scaled(steady({"scale y1 0.1 0.25"})), exact(steady({}));
  const std::vector<double> y1 = readings(exact, 1), of_late = readings(late, 1), of_scaled = readings(scaled, 1);
  std::size_t others = 0;
  for (std::size_t i = 10; i < y1.size(); ++i) {
    const auto [least, most] =
        std::minmax_element(y1.begin() + static_cast<long>(i - 10), y1.begin() + static_cast<long>(i + 1));
    EXPECT_GE(of_late[i], *least - 1e-4);
    EXPECT_LE(of_late[i], *most + 1e-4);
    EXPECT_TRUE(std::abs(of_scaled[i] - y1[i]) < 1e-12 || std::abs(of_scaled[i] - 0.1 * y1[i]) < 1e-12);
    others += std::abs(of_scaled[i] - y1[i]) > 1e-12;
  }
  EXPECT_NEAR(static_cast<double>(others) / static_cast<double>(y1.size()), 0.25, 0.1);
}

TEST(ReadingFaults, EachStationSamplesWhereInItsTurnaroundItIsTold) {
  Options options = steady({"sample all answer", "sample 2 request", "sample 3 middle"});
  options.faults.latency_s = 0.002;
  Responder responder(options);
  for (const auto& [unit, expected] : {std::pair{1, 0.002}, {2, 0.0}, {3, 0.001}}) {
    Request request{};
    request.unit = static_cast<std::uint8_t>(unit);
    EXPECT_NEAR(responder.decide(request, 0.0, nullptr).sample_s, expected, 1e-12) << unit;
  }
}

TEST(ReadingFaults, WhatIsWrongWithALineIsSaid) {
  for (const char* line :
       {"refresh",      "refresh y9 1",      "refresh all -1",   "sample y1 request", "sample 1 never", "clip y1 1 0.5",
        "clip all 0 1", "converter y1 40 1", "converter y1 8 0", "zeros 2 0.1",       "zeros all 2",    "repeats y1 x",
        "stale y1 1",   "freeze y1 0.1",     "garbage y9 1",     "glitch y1",         "scale y1 0",     "lag y1 -1",
        "scale y1 2 3", "lag y1 0.5 0.6",    "low-byte y1 256",  "swap y1 y1",        "nonsense 1",     ""}) {
    Options options;
    options.lines = {line};
    EXPECT_NE(Device::fault(options), "") << line;
  }
}

std::vector<std::vector<double>> recorded(const Options& options) {
  std::stringstream text;
  EXPECT_EQ(write_recording(text, options, {.duration_s = 1.0, .rate_hz = 100}), "");
  std::vector<std::vector<double>> rows;
  std::string line;
  std::getline(text, line);
  while (std::getline(text, line)) {
    std::stringstream cells(line);
    rows.emplace_back();
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(std::stod(cell));
  }
  return rows;
}

TEST(Recording, HasTheFaultsOfReadingsAndTheStuckChannelsOfTheCommandLine) {
  const auto rows = recorded(steady({"stuck y1 on", "refresh reaction 0.05", "clip y2 -0.5 0.5"}));
  const auto exact = recorded(steady({}));
  std::set<double> y1, force;
  double most = 0.0, most_exact = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    y1.insert(rows[i][2]);
    force.insert(rows[i][5]);
    most = std::max(most, std::abs(rows[i][3]));
    most_exact = std::max(most_exact, std::abs(exact[i][3]));
  }
  EXPECT_EQ(y1.size(), 1U);
  EXPECT_LE(force.size(), 21U);
  EXPECT_NEAR(most, 0.5 * most_exact, 0.02 * most_exact);
}

TEST(Recording, HasFrictionASideSpringAndAHuntingAmplitude) {
  Options bent = steady({});
  bent.bend.elements.push_back({4, 10.0, 0.0});
  bent.bend.side.push_back({2, -1, 500, 0});
  bent.bend.hunt = 0.05;
  bent.bend.hunt_hz = 0.5;
  const auto rows = recorded(bent), exact = recorded(steady({}));
  double table = 0.0, force = 0.0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    table = std::max(table, std::abs(rows[i][1] - exact[i][1]));
    force = std::max(force, std::abs(rows[i][5] - exact[i][5]));
  }
  EXPECT_NEAR(table, 0.05 * 0.005, 0.01 * 0.005);
  EXPECT_GT(force, 5.0);
}

class ServedFaults : public test::Rig {};

TEST_F(ServedFaults, AControlLineChangesWhatARegisterHolds) {
  start();
  set_time(1.0);
  ok("refresh reaction 0.5");
  ok("clip y1 -0.1 0.1");
  set_time(1.3);
  EXPECT_NEAR(read(1)[kForce], truth(1.0)[kForce], 1e-5 * 50);
  set_time(1.49);
  EXPECT_NEAR(read(1)[kForce], truth(1.0)[kForce], 1e-5 * 50);
  set_time(1.51);
  EXPECT_NEAR(read(1)[kForce], truth(1.5)[kForce], 1e-5 * 50);
  EXPECT_LT(std::abs(read(1)[1]), 0.0025);
  EXPECT_EQ(server->command("clip y1 1 0").substr(0, 5), "error");
}

}  // namespace
}  // namespace rigsim
