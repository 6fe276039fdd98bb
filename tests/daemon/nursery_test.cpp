// Pipelines made ahead by a thread of its own.
#include "daemon/estimate/nursery.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "tests/daemon/one_mass_rig.hpp"

namespace dwell {
namespace {

struct NurseryTest : testing::Test {
  Nursery::Make maker() {
    return [this] {
      ++made;
      return std::make_unique<RunPipeline>(rig, KeptDwells(1, 1'000'000), nullptr, [](RunPipeline&, RunEvent) {});
    };
  }

  Rig rig = test::one_mass_rig();
  std::atomic<int> made{0};
};

TEST_F(NurseryTest, KeepsOneInStockAndMakesAnotherWhenItIsTaken) {
  Nursery nursery(maker(), true);
  for (int i = 0; i < 5; ++i) {
    std::unique_ptr<RunPipeline> ready;
    while (!(ready = nursery.take())) std::this_thread::yield();
    EXPECT_EQ(ready->position(), 0u);
    nursery.give_up(std::move(ready));
  }
  EXPECT_GE(made.load(), 5);
  EXPECT_LE(made.load(), 6);
}

TEST_F(NurseryTest, WhoCannotWaitGetsOneAtOnce) {
  Nursery nursery(maker(), true);
  for (int i = 0; i < 20; ++i) {
    auto ready = nursery.take_now();
    ASSERT_TRUE(ready);
    nursery.give_up(std::move(ready));
  }
}

TEST_F(NurseryTest, InVirtualTimeAllIsDoneAtOnce) {
  Nursery nursery(maker(), false);
  EXPECT_EQ(made, 0);
  auto first = nursery.take();
  ASSERT_TRUE(first);
  EXPECT_EQ(made, 1);
  nursery.give_up(std::move(first));
}

}  // namespace
}  // namespace dwell
