// Which SYNC an answer belongs to: held against a node of which it is known.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <deque>

#include "drivers/canopen/attribution.hpp"
#include "drivers/canopen/value.hpp"

namespace dwell::canopen {
namespace {

using Outcome = Attribution::Outcome;

TEST(Attribution, GivesEachSyncItsAnswer) {
  Attribution a;
  for (int i = 0; i < 3; ++i) {
    a.begin();
    a.answer();
    EXPECT_EQ(a.close(), Outcome::answered);
  }
  EXPECT_FALSE(a.wants_pause());
}

TEST(Attribution, DoubtsTheAnswerAfterOneThatIsMissingUntilAPause) {
  Attribution a;
  a.begin();
  EXPECT_EQ(a.close(), Outcome::missing);
  EXPECT_FALSE(a.wants_pause());  // a node that is silent costs no pauses
  a.begin();
  a.answer();
  EXPECT_EQ(a.close(), Outcome::doubtful);
  EXPECT_TRUE(a.wants_pause());
  a.forget();
  a.begin();
  a.answer();
  EXPECT_EQ(a.close(), Outcome::answered);
}

TEST(Attribution, KnowsTheLastOfAsManyAnswersAsSyncs) {
  Attribution a;
  a.begin();
  a.close();
  a.begin();
  a.answer();
  a.answer();
  EXPECT_EQ(a.close(), Outcome::answered);
  EXPECT_EQ(a.take_late(), 1U);
}

TEST(Attribution, IsSureAgainOnceTheLateAnswerHasCome) {
  Attribution a;
  a.begin();
  a.close();
  a.late();
  a.begin();
  a.answer();
  EXPECT_EQ(a.close(), Outcome::answered);
}

TEST(Attribution, DoubtsTwoAnswersToOneSync) {
  Attribution a;
  a.begin();
  a.answer();
  a.answer();
  EXPECT_EQ(a.close(), Outcome::doubtful);
  EXPECT_TRUE(a.wants_pause());
}

// A node answers in turn, each SYNC once or not at all, each answer up to five SYNCs late; pauses drain it. Whatever it
// does, an answer that is delivered is the current SYNC's.
RC_GTEST_PROP(Attribution, NeverDeliversAnAnswerToAnotherSync, ()) {
  const auto steps = *rc::gen::container<std::vector<std::pair<int, int>>>(
      rc::gen::pair(rc::gen::inRange(0, 10), rc::gen::inRange(0, 10)));
  Attribution a;
  std::deque<std::pair<int, int>> coming;  // SYNC, and the one in whose window it comes
  int sync = 0;
  for (const auto& [what, delay] : steps) {
    ++sync;
    a.begin();
    const int earliest = coming.empty() ? sync : coming.back().second;
    if (what != 0) coming.emplace_back(sync, std::max(earliest, sync + (delay >= 6 ? delay - 5 : 0)));
    int last = 0;
    for (; !coming.empty() && coming.front().second <= sync; coming.pop_front()) {
      a.answer();
      last = coming.front().first;
    }
    const Outcome outcome = a.close();
    if (outcome == Outcome::answered) RC_ASSERT(last == sync);
    if (a.wants_pause() && what % 2 == 1) {
      for (; !coming.empty(); coming.pop_front()) a.late();
      a.forget();
    }
  }
}

TEST(CanopenValue, ReadsEveryTypeAtAnyBit) {
  const std::uint8_t bytes[8] = {0xFF, 0x9C, 0xFF, 0xFF, 0xFF, 0, 0, 0x80};
  EXPECT_EQ(read_value(bytes, 8, {Kind::signed_integer, 32}).value, -100.0);
  EXPECT_EQ(read_value(bytes, 8, {Kind::signed_integer, 16}).value, -100.0);
  EXPECT_EQ(read_value(bytes, 8, {Kind::unsigned_integer, 16}).value, 65436.0);
  EXPECT_EQ(read_value(bytes, 8, {Kind::signed_integer, 24}).value, -100.0);
  EXPECT_EQ(read_value(bytes, 0, {Kind::unsigned_integer, 8}).value, 255.0);
  EXPECT_EQ(read_value(bytes, 0, {Kind::signed_integer, 64}).value,
            static_cast<double>(static_cast<std::int64_t>(0x800000FFFFFF9CFF)));
  EXPECT_EQ(read_value(bytes, 40, {Kind::signed_integer, 32}).verdict, Verdict::short_frame);
  const std::uint8_t one[5] = {0xAA, 0, 0, 0x80, 0x3F};
  EXPECT_EQ(read_value(one, 8, {Kind::real, 32}).value, 1.0);
  const std::uint8_t none[4] = {0, 0, 0xC0, 0x7F};
  EXPECT_EQ(read_value(none, 0, {Kind::real, 32}).verdict, Verdict::invalid);
}

}  // namespace
}  // namespace dwell::canopen
