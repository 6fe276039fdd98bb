// Plugin and host of different age: what either does not know is not read, and the rest works.
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "config/driver_table.hpp"
#include "daemon/acquire/plugin.hpp"
#include "tests/drivers/fake_host.hpp"
#include "tests/drivers/given.hpp"
#include "tests/drivers/real_host.hpp"

namespace dwell::test {
namespace {

const dwell_driver_table& aged(const char* name) { return *acquire::load_plugin(name, {TEST_AGED_PLUGIN_DIR}).value(); }

class AgedPlugin : public ::testing::TestWithParam<const char*> {};

TEST_P(AgedPlugin, IsLoadedAndDeliversUnderTheRealHost) {
  Given given("device");
  given.channel("one").channel("two");
  FakeHost host;
  RealInstance instance(aged(GetParam()), *given.settings(), host);
  ASSERT_TRUE(instance.exists()) << instance.error();
  ASSERT_TRUE(instance.start()) << instance.error();
  instance.finish();
  ASSERT_EQ(instance.records().size(), 1U);
  EXPECT_EQ(instance.records()[0].value, 42.0);
  EXPECT_EQ(instance.records()[0].channel, Given::kFirstIndex);
  EXPECT_EQ(instance.state(1).fault, DWELL_FAULT_NONE);
  EXPECT_EQ(instance.link().faults(Fault::timeout), 7U);
}

TEST_P(AgedPlugin, HasItsKeysWalkedByItsOwnStride) {
  const auto keys = config::keys_of(aged(GetParam()));
  ASSERT_EQ(keys.size(), 3U);
  EXPECT_STREQ(keys[0].name, "first");
  EXPECT_STREQ(keys[1].name, "second");
  EXPECT_STREQ(keys[2].name, "third");
  EXPECT_EQ(keys[1].minimum, 3.0);
  EXPECT_EQ(keys[2].maximum, 6.0);
  EXPECT_STREQ(keys[2].help, "help of third");
}

INSTANTIATE_TEST_SUITE_P(Every, AgedPlugin, ::testing::Values("older", "newer"),
                         [](const auto& each) { return std::string(each.param); });

TEST(AgedPlugin, IsAskedForNothingThatItsTableEndsBefore) {
  EXPECT_EQ(config::describe_of(aged("older")), nullptr);
  EXPECT_NE(config::describe_of(aged("newer")), nullptr);
}

// As a header would have it that ended before `help`.
TEST(AgedPlugin, HasZeroWhereItsKeysEnd) {
  struct ShortKey {
    alignas(dwell_key) unsigned char bytes[offsetof(dwell_key, help)];
  };
  const dwell_key whole{"rate", DWELL_DEVICE, DWELL_REAL, 1, 2.0, 3.0, nullptr, "Hz", "never seen"};
  std::array<ShortKey, 2> keys{};
  for (ShortKey& key : keys) std::memcpy(&key, &whole, sizeof key);
  dwell_driver_table table{};
  table.keys = reinterpret_cast<const dwell_key*>(keys.data());
  table.key_count = keys.size();
  table.key_size = sizeof(ShortKey);
  for (const dwell_key& key : config::keys_of(table)) {
    EXPECT_STREQ(key.name, "rate");
    EXPECT_EQ(key.maximum, 3.0);
    EXPECT_STREQ(key.unit, "Hz");
    EXPECT_EQ(key.help, nullptr);
  }
}

// A driver made with the wrapper, under hosts of later and earlier headers.
class AgedHost : public ::testing::Test {
 protected:
  AgedHost() {
    std::ofstream(file_) << "t,one\n0,1\n0.001,2\n0.002,3\n";
    given_.set("file", file_.string()).set("speed", 0).channel("one");
  }
  ~AgedHost() override { std::filesystem::remove(file_); }
  // Plays the recording to its end, with these as settings and host.
  void expect_all_is_played(const dwell_settings& settings, const dwell_host& host) {
    void* const instance = table_.create(&settings, &host, nullptr, 0);
    ASSERT_NE(instance, nullptr);
    EXPECT_EQ(table_.start(instance, nullptr, 0), 0);
    EXPECT_TRUE(eventually([&] { return host_.state_of(10).fault == DWELL_FAULT_END_OF_DATA; }));
    table_.destroy(instance);
    EXPECT_EQ(host_.sample_count(), 3U);
  }

  const dwell_driver_table& table_ = *acquire::load_plugin("replay", {TEST_PLUGIN_DIR}).value();
  std::filesystem::path file_ =
      std::filesystem::temp_directory_path() / ("dwell-aged-" + std::to_string(::getpid()) + ".csv");
  Given given_{"device"};
  FakeHost host_;
};

TEST_F(AgedHost, MayKnowMoreThanThePlugin) {
  struct Later {
    dwell_host host;
    void (*later)();
  } later{*host_.host(), [] { std::abort(); }};
  later.host.size = sizeof later;
  struct LaterSettings {
    dwell_settings settings;
    const char* later;
  } settings{*given_.settings(), "never read"};
  settings.settings.size = sizeof settings;
  expect_all_is_played(settings.settings, later.host);
}

TEST_F(AgedHost, MayKnowLessThanThePlugin) {
  dwell_host earlier = *host_.host();
  earlier.size = offsetof(dwell_host, room);
  earlier.room = [](void*) -> std::size_t { std::abort(); };  // not of the struct any more
  expect_all_is_played(*given_.settings(), earlier);
}

TEST_F(AgedHost, HasNothingWrittenBeyondTheTraitsThatThePluginKnows) {
  struct Later {
    dwell_traits traits;
    double later;
  } later{{}, 42.0};
  later.traits.size = sizeof later;
  table_.describe(given_.settings(), &later.traits);
  EXPECT_GT(later.traits.age_ns, 0);
  EXPECT_EQ(later.traits.size, sizeof later);
  EXPECT_EQ(later.later, 42.0);
}

// The real host tells its room: a source that can wait loses nothing to a ring of three samples.
TEST_F(AgedHost, TellsItsRoomToASourceThatCanWait) {
  std::ofstream(file_) << "t,one\n0,1\n0.001,2\n0.002,3\n0.003,4\n0.004,5\n0.005,6\n0.006,7\n";
  RealInstance instance(table_, *given_.settings(), host_, 3);
  ASSERT_TRUE(instance.exists()) << instance.error();
  ASSERT_TRUE(instance.start());
  ASSERT_TRUE(eventually([&] { return host_.sample_count() == 3; }));
  instance.take();
  ASSERT_TRUE(eventually([&] { return host_.state_of(10).fault == DWELL_FAULT_END_OF_DATA; }));
  instance.finish();
  ASSERT_EQ(instance.records().size(), 7U);
  for (std::size_t i = 0; i < 7; ++i) EXPECT_EQ(instance.records()[i].value, static_cast<double>(i + 1));
  EXPECT_EQ(instance.link().counters(0).read().refused, 0U);
}

}  // namespace
}  // namespace dwell::test
