#include "daemon/record/housekeeper.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <thread>

#include "daemon/record/run_folder.hpp"
#include "tests/record/recorded_rig.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {
namespace {

constexpr std::int64_t kMidnight_utc_ns = 1'790'000'000'000'000'000;

// A directory that records nothing, whose ledger is anchored to a file every minute. Virtual time.
struct HousekeeperTest : testing::Test {
  HousekeeperTest() : folder(folder_options(scratch.path(""))) {}

  // Turns within one instant until what the jobs' thread has done is known here.
  void turn_until(double t_s, const std::function<bool()>& known) {
    const auto t_ns = static_cast<std::int64_t>(t_s * 1e9);
    do {
      keeper->turn({t_ns, kMidnight_utc_ns + t_ns}, nullptr);
      std::this_thread::yield();
    } while (!known());
  }

  Scratch scratch;
  const std::string heads = scratch.path("share/heads");
  Notices notices;
  RunFolder folder;
  std::unique_ptr<Housekeeper> keeper;
};

// The share was away when the last run of the day ended: no head changes until the next morning.
TEST_F(HousekeeperTest, AnAnchorThatDidNotArriveIsSentAgainWhenTheNextIsDue) {
  ASSERT_TRUE(folder.open());
  keeper = std::make_unique<Housekeeper>(
      HousekeepingOptions{folder_options(scratch.path("")).directory, {}, {1.0, heads, {}}}, folder,
      std::make_shared<RunList>(), notices.tell());
  turn_until(0.0, [&] { return !keeper->anchor_trouble().empty(); });
  EXPECT_EQ(keeper->anchor_trouble(), heads + ": No such file or directory");
  std::filesystem::create_directory(scratch.path("share"));
  turn_until(60.0, [&] { return keeper->anchor_trouble().empty(); });
  EXPECT_NE(Scratch::read(heads).find("dwell/ledger/"), std::string::npos);
}

}  // namespace
}  // namespace dwell::record
