#include "daemon/health.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

struct HealthTest : testing::Test {
  HealthTest() {
    for (const char* name : {"y0", "y1"}) rig.channels.emplace_back().name = name;
    snapshot.channels.resize(2);
    for (ChannelView& channel : snapshot.channels) {
      channel.fault = Fault::none;
      channel.condition = Condition::ok;
    }
    snapshot.sequence = 1;
    snapshot.dwell.state = State::measuring;
    snapshot.dwell.settled_s = 3.0;
    snapshot.dwell.elements.resize(1);
    snapshot.dwell.elements[0].identifiable = true;
  }
  [[nodiscard]] Health judge() const {
    return judge_health(rig, snapshot, now_ns, lines, log, trouble, recorder, synchronized, utc_ns);
  }
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const Trouble& found : judge().troubles) names.push_back(found.name);
    return names;
  }
  void expect(Health::Status status, bool ready, const std::string& reason) const {
    const Health health = judge();
    EXPECT_EQ(to_string(health.status), std::string(to_string(status)));
    EXPECT_EQ(health.ready, ready);
    EXPECT_EQ(reason_of(health), reason);
  }

  Rig rig;
  Snapshot snapshot;
  gpio::Status lines{};
  LogStats log;
  std::string trouble;
  std::vector<record::RecorderAlarm> recorder;
  bool synchronized = true;
  std::int64_t utc_ns = 0;
  std::int64_t now_ns = 100'000'000;  // 0.1 s after the estimate
};

TEST_F(HealthTest, IsOkAndReadyWhereADwellMayBeReliedOn) { expect(Health::Status::ok, true, ""); }

TEST_F(HealthTest, IsOkButNotReadyWhileNothingIsMeasured) {
  snapshot.dwell.state = State::settling;
  expect(Health::Status::ok, false, "");
}

TEST_F(HealthTest, IsNotReadyWhereTheCoefficientsMustNotBeReliedOn) {
  snapshot.dwell.doubts.push_back({{1}, "the poles contradict the chain"});
  expect(Health::Status::ok, false, "");
}

TEST_F(HealthTest, IsNotReadyWhereTheEstimateIsNoLongerRenewed) {
  now_ns = 2'500'000'000;
  expect(Health::Status::ok, true, "");
  now_ns = 2'600'000'000;
  expect(Health::Status::ok, false, "");
}

TEST_F(HealthTest, NamesTheChannelThatDoesNotDeliverOrDeliversNothingUsable) {
  snapshot.channels[0].fault = Fault::timeout;
  snapshot.channels[0].reason = "no answer within 0.1 s";
  snapshot.channels[1].condition = Condition::stuck;
  snapshot.channels[1].condition_reason = "the same reading for 12.0 s";
  expect(Health::Status::degraded, true, "channel y0: no answer within 0.1 s; channel y1: the same reading for 12.0 s");
}

TEST_F(HealthTest, TellsOfADeadDeviceOnceAndNotOfEachOfItsChannels) {
  rig.channels[0].device = rig.channels[1].device = 0;
  snapshot.devices.resize(1);
  snapshot.devices[0].name = "amplifier";
  for (ChannelView& channel : snapshot.channels) {
    channel.fault = Fault::timeout;
    channel.reason = "no answer within 0.1 s";
  }
  expect(Health::Status::degraded, true, "device amplifier does not deliver: no answer within 0.1 s");
  EXPECT_EQ(names(), (std::vector<std::string>{"device:amplifier"}));
  snapshot.devices[0].up = true;
  EXPECT_EQ(names(), (std::vector<std::string>{"channel:y0", "channel:y1"}));
}

TEST_F(HealthTest, IsDegradedByAViolatedLimitAndNotByAnUndecidedOne) {
  rig.limits = {{1, Bounds{7500.0, 8500.0}, std::nullopt}};
  snapshot.dwell.elements[0].k = 1;
  snapshot.dwell.elements[0].stiffness = {9000.0, 50.0, 100.0, 100.0, true};
  expect(Health::Status::degraded, true,
         "limit violated: stiffness of element 1 is 9.00 ± 0.10 kN/m, outside 7.500 to 8.500 kN/m");
  EXPECT_EQ(names(), (std::vector<std::string>{"limit:stiffness:1"}));
  snapshot.dwell.elements[0].stiffness.value = 8550.0;
  expect(Health::Status::ok, true, "");
  EXPECT_TRUE(names().empty());
}

// After `stop` with the drive on, the alarm of the limit stayed while /metrics said that nothing was measured.
TEST_F(HealthTest, KnowsOfAViolatedLimitOnlyWhileItIsMeasured) {
  rig.limits = {{1, Bounds{7500.0, 8500.0}, std::nullopt}};
  snapshot.dwell.elements[0].k = 1;
  snapshot.dwell.elements[0].stiffness = {9000.0, 50.0, 100.0, 100.0, true};
  EXPECT_EQ(names(), (std::vector<std::string>{"limit:stiffness:1"}));
  snapshot.dwell.state = State::complete;
  EXPECT_TRUE(names().empty());
  snapshot.dwell.state = State::measuring;
  now_ns = 2'600'000'000;
  EXPECT_TRUE(names().empty()) << "the estimate is overdue";
  now_ns = 100'000'000;
  trouble = "thread estimate has not turned for 3.0 s";
  EXPECT_EQ(names(), (std::vector<std::string>{"service"}));
}

TEST_F(HealthTest, DoesNotKnowOfALimitWhoseNumberIsWithheldWhileTheRigIsMeasured) {
  rig.limits = {{1, Bounds{7500.0, 8500.0}, std::nullopt}};
  snapshot.dwell.elements[0].k = 1;
  const auto unknown = [this] {
    std::string text;
    for (const Trouble& one : judge().unknown) text += one.name + " " + one.text + "; ";
    return text;
  };
  for (const double stiffness : {9000.0, 8550.0, 8000.0}) {  // violated, undecided, kept
    snapshot.dwell.elements[0].stiffness = {stiffness, 50.0, 100.0, 100.0, true};
    EXPECT_EQ(unknown(), "") << stiffness;
  }
  snapshot.dwell.state = State::settling;
  EXPECT_EQ(unknown(),
            "limit:stiffness:1 limit was violated; no verdict now on the stiffness of element 1: "
            "not settled; ");
  EXPECT_TRUE(names().empty());
  snapshot.dwell.state = State::complete;
  EXPECT_EQ(unknown(), "") << "nothing is measured any more";
  snapshot.dwell.state = State::fault;
  EXPECT_NE(unknown(), "") << "the data do not suffice now";
  snapshot.devices.resize(1);
  snapshot.devices[0].ended = true;
  EXPECT_EQ(unknown(), "") << "a recording was played to its end";
  snapshot.devices.clear();
  snapshot.dwell.state = State::measuring;
  now_ns = 2'600'000'000;
  EXPECT_EQ(unknown(),
            "limit:stiffness:1 limit was violated; no verdict now on the stiffness of element 1: "
            "the estimate is stale; ");
}

TEST_F(HealthTest, StaysOkWhereOnlyTheComputersClockIsNotSynchronized) {
  synchronized = false;
  expect(Health::Status::ok, true, "");
  EXPECT_EQ(names(), (std::vector<std::string>{"clock"}));
}

TEST_F(HealthTest, KeepsTroublesOfTheRecordingApart) {
  recorder = {{"recording", "the run is not recorded: disk full"}, {"anchor", "heads are not anchored: exit status 1"}};
  expect(Health::Status::degraded, true, "the run is not recorded: disk full; heads are not anchored: exit status 1");
  EXPECT_EQ(names(), (std::vector<std::string>{"recording", "anchor"}));
}

TEST_F(HealthTest, IsNotDegradedByReadingsThatAreModelledOrLeftOut) {
  snapshot.channels[0].condition = Condition::held;
  snapshot.channels[1].condition = Condition::gated;
  expect(Health::Status::ok, true, "");
}

// Then the garbage may be what keeps it from settling, and the dwell itself does not say so.
TEST_F(HealthTest, IsDegradedByAGatedChannelWhileTheDwellSettles) {
  snapshot.dwell.state = State::settling;
  snapshot.dwell.settled_s = kNaN;
  rig.channels[1].at = 1;
  snapshot.channels[1].condition = Condition::gated;
  snapshot.channels[1].condition_reason = "left out of 2804 readings: 169 readings far from all others";
  expect(Health::Status::degraded, false, "channel y1: left out of 2804 readings: 169 readings far from all others");
  EXPECT_EQ(names(), (std::vector<std::string>{"channel:y1"}));
  snapshot.channels[1].fault = Fault::timeout;
  EXPECT_EQ(names().size(), 1u) << "one trouble of a channel";
  snapshot.channels[1].fault = Fault::none;
  rig.channels[1].measures = Quantity::auxiliary;
  expect(Health::Status::ok, false, "");
  // Another transducer at the same place does.
  rig.channels[1].measures = Quantity::displacement;
  rig.channels.push_back(rig.channels[1]);
  rig.channels.back().name = "y1 again";
  snapshot.channels.push_back(snapshot.channels[0]);
  expect(Health::Status::ok, false, "");
  now_ns = 2'600'000'000;
  rig.channels.pop_back();
  snapshot.channels.pop_back();
  EXPECT_TRUE(names().empty()) << "the estimate is overdue: nothing is known of now";
}

// A channel that was stuck and moves again seems well. Without a re-arm its elements stay withheld.
TEST_F(HealthTest, IsDegradedByAChannelThatTheDwellDoesNotUse) {
  snapshot.dwell.phasors.resize(2);
  snapshot.dwell.phasors[0].valid = true;
  snapshot.dwell.phasors[1].reason = "left out of 9000 readings: 4000 repeats of an older reading";
  snapshot.dwell.elements[0].identifiable = false;
  snapshot.dwell.elements[0].reason = "y1: left out of 9000 readings: 4000 repeats of an older reading";
  snapshot.channels[1].condition = Condition::gated;
  const std::string reason =
      "channel y1: not counted in this dwell: left out of 9000 readings: 4000 repeats of an older reading";
  expect(Health::Status::degraded, false, reason);
  EXPECT_EQ(names(), (std::vector<std::string>{"channel:y1"}));
  snapshot.channels[1].condition = Condition::stuck;
  snapshot.channels[1].condition_reason = "stuck at one reading for 12.0 s";
  expect(Health::Status::degraded, false, "channel y1: stuck at one reading for 12.0 s");
  EXPECT_EQ(names().size(), 1u) << "one trouble of a channel, under one name";
  snapshot.channels[1].condition = Condition::ok;
  rig.channels[1].measures = Quantity::auxiliary;
  expect(Health::Status::ok, false, "");
  rig.channels[1].measures = Quantity::displacement;
  now_ns = 2'600'000'000;
  EXPECT_TRUE(names().empty()) << "the estimate is overdue: nothing is known of now";
  now_ns = 100'000'000;
  snapshot.dwell.state = State::settling;
  EXPECT_TRUE(names().empty()) << "nothing is measured";
}

TEST_F(HealthTest, ATroubleTellsItsKindAndItsChannel) {
  snapshot.channels[0].condition = Condition::stuck;
  snapshot.channels[0].condition_reason = "stuck at one reading for 12.0 s";
  snapshot.dwell.phasors.resize(2);
  snapshot.dwell.phasors[1].reason = "left out";
  rig.channels[1].calibration = {"K-7", "2025-03-31"};
  utc_ns = 1'800'000'000'000'000'000;
  recorder = {{"anchor", "no answer"}};
  std::string told;
  for (const Trouble& found : judge().troubles)
    told += std::string(to_string(found.kind)) + "|" + found.channel + "|" + found.why + "\n";
  EXPECT_EQ(told,
            "channel|y0|stuck at one reading for 12.0 s\n"
            "channel|y1|not counted in this dwell: left out\n"
            "recording||\n"
            "calibration|y1|\n");
}

TEST_F(HealthTest, IsDegradedWhereADwellIsMeasuredWithoutAnyCoefficient) {
  snapshot.dwell.elements.clear();
  snapshot.dwell.settling_reason = "too few sync pulses in the data that count";
  expect(Health::Status::degraded, false, "no coefficients: too few sync pulses in the data that count");
  EXPECT_EQ(names(), (std::vector<std::string>{"dwell"}));
}

TEST_F(HealthTest, IsOkWhereTheDriveDoesNotResolveAnElement) {
  snapshot.dwell.phasors.resize(2);
  for (ChannelPhasor& phasor : snapshot.dwell.phasors) phasor.valid = true;
  snapshot.dwell.elements[0].identifiable = false;
  snapshot.dwell.elements[0].reason = "its deformation is too small to measure: |d| is not above 3 u(d)";
  expect(Health::Status::ok, false, "");
}

TEST_F(HealthTest, IsDegradedByLinesOfTheLogThatAreLost) {
  log = {500, 29, true, "No space left on device"};
  expect(Health::Status::degraded, true, "the log loses lines, 29 so far: No space left on device");
  log.failing = false;
  expect(Health::Status::ok, true, "");
}

TEST_F(HealthTest, IsDegradedWhereTheDwellsDataDoNotSuffice) {
  snapshot.dwell.state = State::fault;
  snapshot.dwell.settling_reason = "no sync pulse for 2.0 s";
  expect(Health::Status::degraded, false, "no sync pulse for 2.0 s");
}

TEST_F(HealthTest, TellsOfGpioLinesAndIsNotReadyWhileTheInterlockIsOpen) {
  lines[0] = {true, true, "", false, 0, 0, 0};
  expect(Health::Status::ok, false, "");
  lines[0] = {true, true, "", true, 0, 0, 0};
  expect(Health::Status::ok, true, "");
  lines[2] = {true, false, "there is no /dev/gpiochip0", std::nullopt, 0, 0, 0};
  expect(Health::Status::degraded, true, "GPIO ready: there is no /dev/gpiochip0");
}

TEST_F(HealthTest, IsAFaultWhereTheServiceItselfDoesNotWork) {
  trouble = "thread estimate has not turned for 3.0 s";
  expect(Health::Status::fault, false, "thread estimate has not turned for 3.0 s");
}

constexpr std::int64_t kDay_ns = 86'400'000'000'000;

// The date stood only in exports and reports: nobody saw that a transducer's calibration was overdue.
TEST_F(HealthTest, AnOverdueCalibrationIsATroubleThatLeavesTheStatusOk) {
  rig.channels[1].calibration.id = "K-2231";
  rig.channels[1].calibration.due = "1970-01-11";
  utc_ns = 11 * kDay_ns - 1;
  EXPECT_TRUE(names().empty()) << "it holds to the end of that day";
  utc_ns = 11 * kDay_ns;
  EXPECT_EQ(names(), (std::vector<std::string>{"calibration:y1"}));
  EXPECT_EQ(judge().troubles[0].text, "channel y1: the calibration K-2231 is overdue: it was due on 1970-01-11");
  expect(Health::Status::ok, true, "");
  synchronized = false;
  EXPECT_EQ(names(), (std::vector<std::string>{"clock"})) << "nobody knows what day it is";
}

// A recording that was played to its end raised three alarms.
TEST_F(HealthTest, TheEndOfARecordingIsNoTrouble) {
  snapshot.devices.resize(1);
  snapshot.devices[0].ended = true;
  for (std::size_t i = 0; i < 2; ++i) {
    rig.channels[i].device = 0;
    snapshot.channels[i].fault = Fault::end_of_data;
  }
  snapshot.dwell.state = State::fault;
  snapshot.dwell.settling_reason = "the drive is not seen: y0 is end of data";
  EXPECT_TRUE(names().empty());
  expect(Health::Status::ok, false, "");
}

TEST_F(HealthTest, CountsReasonsBeyondTheFirstFew) {
  rig.channels.resize(100);
  snapshot.channels.assign(100, ChannelView{});
  const std::string reason = reason_of(judge());
  EXPECT_NE(reason.find("; and 95 more"), std::string::npos) << reason;
}

}  // namespace
}  // namespace dwell
