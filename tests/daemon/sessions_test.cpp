// A browser's session with the service.
#include "daemon/serve/sessions.hpp"

#include <gtest/gtest.h>

#include <set>

namespace dwell {
namespace {

TEST(Sessions, GoOnWhileTheyAreUsedAndEndAShiftAfter) {
  Sessions sessions;
  const std::string used = sessions.begin(0), unused = sessions.begin(0);
  EXPECT_TRUE(sessions.use(used, Sessions::kUnused_ns));
  EXPECT_TRUE(sessions.use(used, 2 * Sessions::kUnused_ns));
  EXPECT_FALSE(sessions.use(unused, 2 * Sessions::kUnused_ns));
  EXPECT_EQ(sessions.count(), 1u) << "and what has ended is kept no longer";
  EXPECT_FALSE(sessions.use(used, 3 * Sessions::kUnused_ns + 1));
}

TEST(Sessions, EndInTimeThoughAnOpenPageUsesThemEachSecond) {
  Sessions sessions;
  const std::string page = sessions.begin(0);
  std::int64_t now_ns = 0;
  for (; now_ns <= Sessions::kLongest_ns; now_ns += 60'000'000'000) ASSERT_TRUE(sessions.use(page, now_ns)) << now_ns;
  EXPECT_FALSE(sessions.use(page, now_ns));
}

TEST(Sessions, TellOnceWhichHaveEnded) {
  Sessions sessions;
  const std::string out = sessions.begin(0), unused = sessions.begin(0), open = sessions.begin(0);
  EXPECT_TRUE(sessions.use(open, Sessions::kUnused_ns));
  sessions.end(out);
  sessions.end("none");
  EXPECT_EQ(sessions.take_ended(Sessions::kUnused_ns), std::vector<std::string>{out});
  EXPECT_EQ(sessions.take_ended(Sessions::kUnused_ns + 1), std::vector<std::string>{unused});
  for (std::size_t i = 0; i < Sessions::kMost; ++i) (void)sessions.begin(Sessions::kUnused_ns + 2);
  EXPECT_EQ(sessions.take_ended(Sessions::kUnused_ns + 2), std::vector<std::string>{open}) << "it made room";
  sessions.end_all();
  EXPECT_EQ(sessions.take_ended(Sessions::kUnused_ns + 2).size(), Sessions::kMost);
  EXPECT_TRUE(sessions.take_ended(Sessions::kUnused_ns + 2).empty());
}

TEST(Sessions, AreKnownByTheirWholeValueAlone) {
  Sessions sessions;
  const std::string value = sessions.begin(0);
  EXPECT_EQ(value.size(), 64u);
  for (const std::string& wrong : {std::string(), value.substr(1), value + "0", std::string(64, '0')})
    EXPECT_FALSE(sessions.use(wrong, 0)) << wrong;
  EXPECT_NE(value, sessions.begin(0));
}

TEST(Sessions, EndOneByOneAndAllTogether) {
  Sessions sessions;
  const std::string a = sessions.begin(0), b = sessions.begin(0), c = sessions.begin(0);
  sessions.end(a);
  sessions.end("none");
  EXPECT_FALSE(sessions.use(a, 0));
  EXPECT_TRUE(sessions.use(b, 0));
  sessions.end_all();
  EXPECT_FALSE(sessions.use(b, 0) || sessions.use(c, 0));
}

TEST(Sessions, AreBoundedAndTheOneUsedLeastRecentlyMakesRoom) {
  Sessions sessions;
  const std::string first = sessions.begin(0), second = sessions.begin(1);
  for (std::size_t i = 2; i < Sessions::kMost; ++i) (void)sessions.begin(2);
  EXPECT_TRUE(sessions.use(first, 3));
  (void)sessions.begin(4);
  EXPECT_EQ(sessions.count(), Sessions::kMost);
  EXPECT_TRUE(sessions.use(first, 5));
  EXPECT_FALSE(sessions.use(second, 5));
}

TEST(Sessions, AreFoundAmongTheCookiesOfOthers) {
  EXPECT_EQ(cookie_value("dwell_1=abc", "dwell_1"), "abc");
  EXPECT_EQ(cookie_value("a=b; dwell_1=abc; dwell_12=x", "dwell_1"), "abc");
  EXPECT_EQ(cookie_value("dwell_12=x;dwell_1=", "dwell_1"), "");
  for (const char* none : {"", ";", "=", "; ;", "dwell_1", "xdwell_1=abc", "a=dwell_1=abc"})
    EXPECT_EQ(cookie_value(none, "dwell_1"), "") << none;
}

}  // namespace
}  // namespace dwell
