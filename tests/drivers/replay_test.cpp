#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/acquire/plugin.hpp"
#include "tests/drivers/fake_host.hpp"
#include "tests/drivers/given.hpp"

namespace dwell::test {
namespace {

const dwell_driver_table& driver_table() { return *acquire::load_plugin("replay", {TEST_PLUGIN_DIR}).value(); }

class ReplayPlugin : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("dwell-replay-" + std::to_string(::getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  void write(const std::string& text) const { std::ofstream(folder_ / "a.csv") << text; }
  // Relative to the rig file's folder.
  Given given() const {
    Given device("recording", folder_.string());
    device.set("file", "a.csv");
    return device;
  }
  std::filesystem::path folder_;
};

TEST_F(ReplayPlugin, PlaysEveryNumberInOrderWithTheRecordingsOwnSpacing) {
  write("t,y0,y1\n10,1,2\n10.25,3,\n11,5,6\n");
  Given device = given().set("speed", 0).channel("y1").channel("y0");
  FakeHost host;
  Instance instance(driver_table(), *device.settings(), host);
  const std::int64_t before_ns = driver::raw_ns();
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.state_of(10).fault == DWELL_FAULT_END_OF_DATA; }));
  const std::int64_t after_ns = driver::raw_ns();
  const auto y0 = host.samples(11);
  const auto y1 = host.samples(10);
  ASSERT_EQ(y0.size(), 3U);
  ASSERT_EQ(y1.size(), 2U);
  EXPECT_EQ(y0[1].raw, 3.0);
  EXPECT_EQ(y1[1].raw, 6.0);
  EXPECT_EQ(y0[1].t_ns - y0[0].t_ns, 250'000'000);
  EXPECT_EQ(y1[1].t_ns - y1[0].t_ns, 1'000'000'000);
  EXPECT_EQ(y0[0].t_ns, y1[0].t_ns);
  EXPECT_GE(y0[0].t_ns, before_ns);
  EXPECT_LE(y0[0].t_ns, after_ns);
  EXPECT_EQ(host.scans(), (std::vector<std::size_t>{2, 1, 2}));
}

TEST_F(ReplayPlugin, WaitsForRoomInsteadOfLosingAScan) {
  std::string text = "t,y0,y1\n";
  for (int i = 0; i < 500; ++i) text += std::to_string(i) + "," + std::to_string(i) + ",0\n";
  write(text);
  Given device = given().set("speed", 0).channel("y0").channel("y1");
  FakeHost host;
  host.set_room(3);
  Instance instance(driver_table(), *device.settings(), host);
  ASSERT_TRUE(instance.start());
  while (host.state_of(10).fault != DWELL_FAULT_END_OF_DATA) {
    const std::size_t turns = host.turns();
    ASSERT_TRUE(eventually([&] { return host.turns() > turns || host.state_of(10).fault == DWELL_FAULT_END_OF_DATA; }));
    host.set_room(21);
  }
  EXPECT_EQ(host.refused(), 0U);
  const auto y0 = host.samples(10);
  ASSERT_EQ(y0.size(), 500U);
  for (std::size_t i = 0; i < y0.size(); ++i) ASSERT_EQ(y0[i].raw, static_cast<double>(i));
}

TEST_F(ReplayPlugin, PlaysAtTheSpeedAskedFor) {
  write("t,y0\n0,1\n0.2,2\n0.4,3\n");
  Given device = given().set("speed", 2.0).channel("y0");
  FakeHost host;
  Instance instance(driver_table(), *device.settings(), host);
  const std::int64_t before_ns = driver::monotonic_ns();
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() == 3; }));
  EXPECT_GE(driver::monotonic_ns() - before_ns, 200'000'000);
  EXPECT_EQ(host.samples()[2].t_ns - host.samples()[0].t_ns, 400'000'000);
}

TEST_F(ReplayPlugin, BeginsAnewAndMarksTheSplice) {
  write("t,y0\n0,1\n0.001,2\n");
  Given device = given().set("loop", true).channel("y0");
  FakeHost host;
  Instance instance(driver_table(), *device.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 6; }));
  instance.stop();
  const auto samples = host.samples();
  for (std::size_t i = 1; i < 6; ++i) {
    EXPECT_EQ(samples[i].t_ns - samples[i - 1].t_ns, 1'000'000);
    EXPECT_EQ(samples[i].raw, i % 2 == 0 ? 1.0 : 2.0);
    EXPECT_EQ(samples[i].flags, i % 2 == 0 ? DWELL_SAMPLE_GAP : 0U);
  }
}

TEST_F(ReplayPlugin, IsNotBusyWithALoopThatHoldsNothingForIt) {
  write("t,y0,y1\n0,1,\n1,2,\n");
  Given device = given().set("loop", true).set("speed", 0).channel("y1");
  FakeHost host;
  Instance instance(driver_table(), *device.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.state_of(10).fault == DWELL_FAULT_END_OF_DATA; }));
  EXPECT_LT(instance.stop(), 0.5);
}

TEST_F(ReplayPlugin, MarksAChannelThatTheRecordingDoesNotHave) {
  write("t,y0\n0,1\n0.001,2\n");
  Given device = given().set("loop", true).channel("y0").channel("y7");
  FakeHost host;
  Instance instance(driver_table(), *device.settings(), host);
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 3; }));
  EXPECT_EQ(host.state_of(10).fault, DWELL_FAULT_NONE);
  EXPECT_EQ(host.state_of(11).fault, DWELL_FAULT_DISCONNECTED);
  EXPECT_EQ(host.state_of(11).reason, "the recording has no channel `y7`; it has y0");
}

TEST_F(ReplayPlugin, ReportsEveryMistakeAtOnce) {
  write("t,y0\n0,1\n");
  Given device = given().channel("a").set("column", "y0").channel("y0").channel("y5");
  const auto mistakes = mistakes_of(driver_table(), *device.settings());
  ASSERT_EQ(mistakes.size(), 2U);
  EXPECT_EQ(mistakes[0], "channel 1, column: another channel takes `y0` already");
  EXPECT_EQ(mistakes[1], "channel 2, column: the recording has no channel `y5`; it has y0");
  write("t,y0\n0,x\n");
  const auto broken = mistakes_of(driver_table(), *device.settings());
  ASSERT_EQ(broken.size(), 2U);
  EXPECT_EQ(broken[0], "device, file: " + (folder_ / "a.csv").string() + ":2:3: the value is `x`; expected a number");
}

TEST_F(ReplayPlugin, ProbesTheFirstValues) {
  write("t,y0,y1\n0,,4\n1,3,5\n");
  Given device = given().channel("y0").channel("y1").channel("y2");
  const auto results = probe(driver_table(), *device.settings());
  EXPECT_EQ(results.at(0).raw, 3.0);
  EXPECT_EQ(results.at(1).raw, 4.0);
  EXPECT_NE(results.at(2).error, "");
}

}  // namespace
}  // namespace dwell::test
