// The contract of dwell_driver.h, held against every driver alike, under a host of the tests and under the service's
// own.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <ostream>
#include <thread>

#include "daemon/acquire/plugin.hpp"
#include "tests/drivers/contract_devices.hpp"
#include "tests/drivers/fake_host.hpp"
#include "tests/drivers/real_host.hpp"

namespace dwell::test {

namespace {

enum class Under { test_host, real_host };
void PrintTo(Under under, std::ostream* out) { *out << (under == Under::real_host ? "real host" : "test host"); }
using Param = std::tuple<Case, Under>;

class DriverContract : public ::testing::TestWithParam<Param> {
 protected:
  void SetUp() override {
    if (const std::string lacking = device_->lacking(); !lacking.empty()) GTEST_SKIP() << "this needs " << lacking;
  }

  [[nodiscard]] bool under_real_host() const { return std::get<Under>(GetParam()) == Under::real_host; }
  // The instance that the test is about; under the real host its ring is drained unless it shall be small.
  std::unique_ptr<Driven> make() {
    if (!under_real_host()) return std::make_unique<Instance>(table_, *given_.settings(), host_);
    auto made = std::make_unique<RealInstance>(table_, *given_.settings(), host_, small_ring_ ? kSmallRing : 0);
    real_ = made.get();
    if (made->exists() && !small_ring_) made->take();
    return made;
  }
  // Two scans and half of a third find room.
  void give_little_room() {
    host_.set_room(kSmallRing);
    small_ring_ = true;
  }
  void give_room() {
    host_.set_room(1000);
    if (under_real_host()) real_->take();
  }
  // What the real host got is what the driver said. The instance is still there.
  void expect_the_real_host_knows_it() {
    if (!under_real_host()) return;
    real_->finish();
    const auto samples = host_.samples();
    ASSERT_EQ(real_->records().size(), samples.size());
    for (std::size_t i = 0; i < samples.size(); ++i) {
      ASSERT_EQ(real_->records()[i].t_ns, samples[i].t_ns);
      ASSERT_EQ(real_->records()[i].value, samples[i].raw);
      ASSERT_EQ(real_->records()[i].channel, samples[i].channel);
      ASSERT_EQ(real_->records()[i].flags & samples[i].flags, samples[i].flags);
    }
    DeviceLink& link = real_->link();
    for (int position = 0; position < 2; ++position) {
      const auto channel = static_cast<std::uint16_t>(Given::kFirstIndex + position);
      EXPECT_EQ(link.counters(position).read().received, host_.samples(channel).size() + host_.refused());
      EXPECT_EQ(link.counters(position).read().refused, host_.refused());
      EXPECT_EQ(real_->state(static_cast<std::size_t>(position)).fault, host_.state_of(channel).fault);
      EXPECT_EQ(real_->state(static_cast<std::size_t>(position)).reason, host_.state_of(channel).reason);
    }
    for (int fault = 0; fault < kFaultCount; ++fault)
      EXPECT_EQ(link.faults(static_cast<dwell::Fault>(fault)),
                static_cast<std::uint64_t>(host_.counted(static_cast<dwell_fault>(fault))));
    EXPECT_EQ(link.foreign(), 0U);
  }

  static constexpr std::size_t kSmallRing = 5;
  const dwell_driver_table& table_ =
      *acquire::load_plugin(std::get<Case>(GetParam()).plugin, {TEST_PLUGIN_DIR}).value();
  std::unique_ptr<Device> device_ = std::get<Case>(GetParam()).make();
  Given given_ = device_->given();
  FakeHost host_;
  bool small_ring_ = false;
  RealInstance* real_ = nullptr;  // the instance, where it is one
};

constexpr double kStopWithin_s = 0.5;

TEST_P(DriverContract, DeliversWhatTheDeviceHasWithInstantsInRawTime) {
  device_->come();
  const auto instance = make();
  ASSERT_TRUE(instance->exists()) << instance->error();
  const std::int64_t before_ns = driver::raw_ns();
  ASSERT_TRUE(instance->start()) << instance->error();
  ASSERT_TRUE(eventually([&] { return host_.samples(10).size() >= 20 && host_.samples(11).size() >= 20; }));
  instance->stop();
  const std::int64_t after_ns = driver::raw_ns();
  for (const dwell_sample& sample : host_.samples()) {
    EXPECT_EQ(sample.raw, sample.channel == 10 ? 1.0 : 2.0);
    EXPECT_GE(sample.t_ns + sample.t_half_ns, before_ns);
    EXPECT_LE(sample.t_ns - std::int64_t{sample.t_half_ns}, after_ns);
  }
  EXPECT_EQ(host_.state_of(10).fault, DWELL_FAULT_NONE);
  EXPECT_EQ(host_.state_of(11).fault, DWELL_FAULT_NONE);
  expect_the_real_host_knows_it();
}

TEST_P(DriverContract, StampsAdvanceInEveryChannel) {
  device_->come();
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.sample_count() >= 60; }));
  instance->stop();
  for (const std::uint16_t channel : {std::uint16_t{10}, std::uint16_t{11}}) {
    const auto samples = host_.samples(channel);
    for (std::size_t i = 1; i < samples.size(); ++i) ASSERT_GT(samples[i].t_ns, samples[i - 1].t_ns);
  }
}

TEST_P(DriverContract, TakesARefusedScanAsLostAndGoesOn) {
  device_->come();
  give_little_room();
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.refused() >= 3; }));
  give_room();
  ASSERT_TRUE(eventually([&] { return host_.sample_count() >= 20; }));
  instance->stop();
  for (const std::size_t scan : host_.scans()) EXPECT_EQ(scan, 2U);
  const auto samples = host_.samples(10);
  for (std::size_t i = 1; i < samples.size(); ++i) EXPECT_GT(samples[i].t_ns, samples[i - 1].t_ns);
  expect_the_real_host_knows_it();
}

TEST_P(DriverContract, SaysOfItsReadingsWhatTheSettingsSay) {
  Given wrong = device_->given_wrong().first;
  for (Given* given : {&given_, &wrong}) {
    dwell_traits traits{};
    traits.size = sizeof traits;
    table_.describe(given->settings(), &traits);
    EXPECT_EQ(traits.size, sizeof traits);
    EXPECT_GE(traits.rate_hz, 0.0);
    EXPECT_GT(traits.age_ns, 0) << "how old its samples may be";
    EXPECT_EQ(traits.recorded, std::string(table_.name) == "replay" ? 1 : 0);
  }
  // A host of an earlier version takes less.
  dwell_traits early{};
  early.size = offsetof(dwell_traits, age_ns);
  early.age_ns = 42;
  table_.describe(given_.settings(), &early);
  EXPECT_EQ(early.age_ns, 42);
}

TEST_P(DriverContract, CanBeMadeAndDestroyedWithoutADeviceAndWithoutStart) {
  make();
  const auto instance = make();
  ASSERT_TRUE(instance->exists()) << instance->error();
  EXPECT_LT(instance->stop(), kStopWithin_s);
  EXPECT_EQ(host_.sample_count(), 0U);
}

TEST_P(DriverContract, StopsInTimeWhileTheDeviceIsAbsent) {
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.state_of(10).fault != DWELL_FAULT_SILENT; }));
  EXPECT_LT(instance->stop(), kStopWithin_s);
}

TEST_P(DriverContract, StopsInTimeWhileTheDeviceIsSilent) {
  device_->come();
  if (!device_->fall_silent()) GTEST_SKIP() << "this device cannot be there without delivering";
  given_.set_device("timeout", 2.0);
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.turns() >= 3; }));
  EXPECT_LT(instance->stop(), kStopWithin_s);
}

TEST_P(DriverContract, StopsInTimeWhileDeliveringAndIsQuietAfterwards) {
  device_->come();
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.sample_count() >= 4; }));
  EXPECT_LT(instance->stop(), kStopWithin_s);
  const std::size_t turns = host_.turns();
  const std::size_t samples = host_.sample_count();
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(host_.turns(), turns);
  EXPECT_EQ(host_.sample_count(), samples);
}

TEST_P(DriverContract, StopsAtOnceAfterStart) {
  device_->come();
  for (int i = 0; i < 20; ++i) {
    const auto instance = make();
    ASSERT_TRUE(instance->start());
    EXPECT_LT(instance->stop(), kStopWithin_s);
  }
}

TEST_P(DriverContract, CannotBeStartedTwice) {
  device_->come();
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  EXPECT_FALSE(instance->start());
  EXPECT_FALSE(instance->error().empty());
}

TEST_P(DriverContract, MarksEveryChannelOfAnAbsentDeviceWithAReason) {
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  for (const std::uint16_t channel : {std::uint16_t{10}, std::uint16_t{11}}) {
    ASSERT_TRUE(eventually([&] { return host_.state_of(channel).fault == DWELL_FAULT_DISCONNECTED; }));
    EXPECT_FALSE(host_.state_of(channel).reason.empty());
    EXPECT_EQ(host_.state_of(channel).reason.find('\n'), std::string::npos);
  }
  EXPECT_TRUE(eventually([&] { return host_.counted(DWELL_FAULT_DISCONNECTED) >= 1; })) << "counted after it is told";
}

TEST_P(DriverContract, MarksEveryChannelOfASilentDeviceWithAReason) {
  device_->come();
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.state_of(11).fault == DWELL_FAULT_NONE; }));
  if (!device_->fall_silent()) GTEST_SKIP() << "this device cannot be there without delivering";
  ASSERT_TRUE(eventually([&] { return host_.state_of(10).fault == DWELL_FAULT_TIMEOUT; }));
  ASSERT_TRUE(eventually([&] { return host_.state_of(11).fault == DWELL_FAULT_TIMEOUT; }));
  EXPECT_FALSE(host_.state_of(10).reason.empty());
}

TEST_P(DriverContract, BeginsWhenTheDeviceComes) {
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.state_of(10).fault == DWELL_FAULT_DISCONNECTED; }));
  device_->come();
  ASSERT_TRUE(eventually([&] { return host_.state_of(10).fault == DWELL_FAULT_NONE && host_.sample_count() >= 4; }));
}

TEST_P(DriverContract, RecoversWhenTheDeviceReturns) {
  device_->come();
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.sample_count() >= 4; }));
  if (!device_->fall_silent()) GTEST_SKIP() << "what has been read once stays";
  device_->leave();
  ASSERT_TRUE(eventually([&] { return host_.state_of(10).fault == DWELL_FAULT_DISCONNECTED; }));
  const std::size_t before = host_.sample_count();
  device_->come();
  ASSERT_TRUE(eventually([&] { return host_.sample_count() >= before + 4; }));
  EXPECT_EQ(host_.state_of(10).fault, DWELL_FAULT_NONE);
  expect_the_real_host_knows_it();
}

// How late a thread was woken at most: what a busy machine does to everything that waits.
class Stalls {
 public:
  [[nodiscard]] double longest_s() const { return 1e-9 * static_cast<double>(longest_ns_); }

 private:
  static constexpr std::int64_t kWait_ns = 5'000'000;
  std::atomic<std::int64_t> longest_ns_ = 0;
  std::jthread thread_{[this](const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      const std::int64_t before_ns = driver::monotonic_ns();
      std::this_thread::sleep_for(std::chrono::nanoseconds(kWait_ns));
      longest_ns_ = std::max(longest_ns_.load(), driver::monotonic_ns() - before_ns - kWait_ns);
    }
  }};
};

// Else the host would have put the stream in order without it.
TEST_P(DriverContract, PushesNoSampleOlderThanItSays) {
  dwell_traits traits{};
  traits.size = sizeof traits;
  table_.describe(given_.settings(), &traits);
  const Stalls stalls;
  device_->come();
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.sample_count() >= 60; }));
  instance->stop();
  EXPECT_LE(1e-9 * static_cast<double>(host_.greatest_age_ns()),
            1e-9 * static_cast<double>(traits.age_ns) + 0.01 + stalls.longest_s());
}

// The contract says 0.5 s; as much again is allowed to the machine, and what it is seen to be late.
TEST_P(DriverContract, ReportsItsThreadAliveInEveryState) {
  const Stalls stalls;
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  const std::size_t absent = host_.turns();
  ASSERT_TRUE(eventually([&] { return host_.turns() >= absent + 5; }));
  device_->come();
  ASSERT_TRUE(eventually([&] { return host_.sample_count() >= 4; }));
  const std::size_t delivering = host_.turns();
  ASSERT_TRUE(eventually([&] { return host_.turns() >= delivering + 5; }));
  device_->fall_silent();
  const std::size_t silent = host_.turns();
  ASSERT_TRUE(eventually([&] { return host_.turns() >= silent + 5; }));
  EXPECT_LT(host_.longest_pause_s(), 1.0 + stalls.longest_s());
}

TEST_P(DriverContract, AllocatesNothingPerSample) {
  device_->come();
  const auto instance = make();
  ASSERT_TRUE(instance->start());
  ASSERT_TRUE(eventually([&] { return host_.scans().size() > 120; }));
  EXPECT_EQ(host_.allocating_scans(), 0U);
}

TEST_P(DriverContract, ChecksEveryMistakeAndNothingThatIsRight) {
  device_->come();
  EXPECT_TRUE(mistakes_of(table_, *given_.settings()).empty());
  auto [wrong, count] = device_->given_wrong();
  EXPECT_EQ(mistakes_of(table_, *wrong.settings()).size(), count);
}

TEST_P(DriverContract, ProbesEveryChannelOnce) {
  device_->come();
  Given patient = device_->given();
  patient.set_device("timeout", 2.0);  // a busy machine may hold up the device that answers
  const auto present = probe(table_, *patient.settings());
  ASSERT_EQ(present.size(), 2U);
  EXPECT_EQ(present.at(0).error + present.at(1).error, "");
  EXPECT_EQ(present.at(0).raw, 1.0);
  EXPECT_EQ(present.at(1).raw, 2.0);
  device_->leave();
  const auto absent = probe(table_, *given_.settings());
  ASSERT_EQ(absent.size(), 2U);
  EXPECT_FALSE(absent.at(0).error.empty());
  EXPECT_FALSE(absent.at(1).error.empty());
}

INSTANTIATE_TEST_SUITE_P(Driver, DriverContract,
                         ::testing::Combine(::testing::ValuesIn(kCases),
                                            ::testing::Values(Under::test_host, Under::real_host)),
                         [](const ::testing::TestParamInfo<Param>& each) {
                           return std::string(std::get<Case>(each.param).name) +
                                  (std::get<Under>(each.param) == Under::real_host ? "UnderTheRealHost" : "");
                         });

}  // namespace
}  // namespace dwell::test
