#include "daemon/gpio/edge_filter.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <utility>
#include <vector>

namespace dwell::gpio {
namespace {

using Changes = std::vector<std::pair<std::int64_t, bool>>;

struct Filtered {
  explicit Filtered(bool level, std::int64_t debounce_ns) : filter(level, debounce_ns) {}
  void edge(std::int64_t t_ns, bool to) {
    filter.edge({t_ns, to, false}, [this](std::int64_t t, bool level) { told.emplace_back(t, level); });
  }
  void due(std::int64_t t_ns) {
    filter.due(t_ns, [this](std::int64_t t, bool level) { told.emplace_back(t, level); });
  }
  EdgeFilter filter;
  Changes told;
};

TEST(EdgeFilter, WithoutDebounceTellsEveryEdgeAtItsInstant) {
  Filtered line(true, 0);
  line.edge(10, false);
  line.edge(11, true);
  EXPECT_EQ(line.told, (Changes{{10, false}, {11, true}}));
  EXPECT_EQ(line.filter.bounces(), 0u);
}

TEST(EdgeFilter, TellsTheFirstEdgeOfABounceAtOnceAndNoOther) {
  Filtered line(false, 100);
  line.edge(1000, true);
  EXPECT_EQ(line.told, (Changes{{1000, true}})) << "at once: an interlock must not be lost late";
  line.edge(1010, false);
  line.edge(1020, true);
  line.due(2000);
  EXPECT_EQ(line.told, (Changes{{1000, true}}));
  EXPECT_EQ(line.filter.bounces(), 2u);
}

TEST(EdgeFilter, WhereTheLineStandsAfterBouncingCounts) {
  Filtered line(false, 100);
  line.edge(1000, true);
  line.edge(1010, false);
  line.due(1099);
  EXPECT_EQ(line.told.size(), 1u) << "it may still bounce";
  line.due(1100);
  EXPECT_EQ(line.told, (Changes{{1000, true}, {1100, false}}));
}

TEST(EdgeFilter, ThatIsToldBeforeALaterEdgeEvenIfNobodyAskedInBetween) {
  Filtered line(false, 100);
  line.edge(1000, true);
  line.edge(1010, false);
  line.edge(5000, true);
  EXPECT_EQ(line.told, (Changes{{1000, true}, {1100, false}, {5000, true}}));
}

TEST(EdgeFilter, AnEdgeToWhereTheLineStandsSaysThatItHasBeenAway) {
  Filtered line(true, 0);
  line.edge(1000, true);
  EXPECT_EQ(line.told, (Changes{{1000, false}, {1000, true}}));
}

RC_GTEST_PROP(EdgeFilter, TellsAlternatingLevelsInOrderAndEndsWhereTheLineDoes, ()) {
  const auto debounce_ns = *rc::gen::inRange<std::int64_t>(0, 50);
  const bool start = *rc::gen::arbitrary<bool>();
  const auto steps = *rc::gen::container<std::vector<std::pair<int, bool>>>(
      rc::gen::pair(rc::gen::inRange(0, 100), rc::gen::arbitrary<bool>()));
  Filtered line(start, debounce_ns);
  std::int64_t t_ns = 1000;
  bool level = start;
  for (const auto& [step, to] : steps) {
    t_ns += step;
    level = to;
    line.edge(t_ns, to);
  }
  line.due(t_ns + 1000);
  bool before = start;
  std::int64_t last_ns = 0;
  for (const auto& [at_ns, to] : line.told) {
    RC_ASSERT(to != before);
    RC_ASSERT(at_ns >= last_ns);
    before = to;
    last_ns = at_ns;
  }
  RC_ASSERT(before == level);
  RC_ASSERT(line.filter.level() == level);
}

}  // namespace
}  // namespace dwell::gpio
