#include <gtest/gtest.h>

#include <array>
#include <thread>

#include "daemon/estimate/triple_buffer.hpp"

namespace dwell {
namespace {

TEST(TripleBuffer, HasNothingNewUntilSomethingIsPublished) {
  TripleBuffer<int> buffer;
  EXPECT_FALSE(buffer.update());
  buffer.back() = 7;
  EXPECT_FALSE(buffer.update()) << "written is not published";
  buffer.publish();
  EXPECT_TRUE(buffer.update());
  EXPECT_EQ(buffer.front(), 7);
  EXPECT_FALSE(buffer.update());
  EXPECT_EQ(buffer.front(), 7) << "what was read stays";
}

TEST(TripleBuffer, TheReaderGetsTheNewestOfMany) {
  TripleBuffer<int> buffer;
  for (int i = 1; i <= 10; ++i) {
    buffer.back() = i;
    buffer.publish();
  }
  EXPECT_TRUE(buffer.update());
  EXPECT_EQ(buffer.front(), 10);
}

TEST(TripleBufferThreads, NeverShowsAHalfWrittenValueNorAnOlderOne) {
  constexpr std::uint64_t kValues = 200'000;
  TripleBuffer<std::array<std::uint64_t, 16>> buffer;
  std::thread writer([&] {
    for (std::uint64_t i = 1; i <= kValues; ++i) {
      buffer.back().fill(i);
      buffer.publish();
    }
  });
  std::uint64_t newest = 0;
  while (newest < kValues) {
    if (!buffer.update()) {
      std::this_thread::yield();
      continue;
    }
    const auto& seen = buffer.front();
    ASSERT_GT(seen.front(), newest);
    for (const std::uint64_t part : seen) ASSERT_EQ(part, seen.front());
    newest = seen.front();
  }
  writer.join();
}

}  // namespace
}  // namespace dwell
