// Which event waits where, and which is dropped.
#include "daemon/serve/event_queue.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

struct EventQueueTest : testing::Test {
  bool push(const std::string& name) {
    return queue.push(std::make_shared<const std::string>(name), name.front() == 'y');
  }
  std::string all() {
    std::string names;
    while (const auto event = queue.take()) names += *event + " ";
    return names;
  }
  EventQueue queue{4};
};

TEST_F(EventQueueTest, WhatYieldsWaitsBehindTheOthersEachInItsOrder) {
  for (const char* name : {"y1", "y2", "a", "b"}) EXPECT_TRUE(push(name));
  EXPECT_EQ(all(), "a b y1 y2 ");
  EXPECT_EQ(queue.take(), nullptr);
}

TEST_F(EventQueueTest, WhatYieldsIsDroppedFirst) {
  for (const char* name : {"y1", "y2", "a", "b"}) EXPECT_TRUE(push(name));
  EXPECT_FALSE(push("y3")) << "the oldest that yields goes";
  EXPECT_FALSE(push("c"));
  EXPECT_FALSE(push("d"));
  EXPECT_FALSE(push("y4")) << "none that yields waits: it goes itself";
  EXPECT_EQ(all(), "a b c d ");
}

TEST_F(EventQueueTest, WhereNothingYieldsTheOldestIsDropped) {
  for (const char* name : {"a", "b", "c", "d"}) EXPECT_TRUE(push(name));
  EXPECT_FALSE(push("e"));
  EXPECT_EQ(all(), "b c d e ");
}

}  // namespace
}  // namespace dwell
