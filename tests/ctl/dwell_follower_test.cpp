#include "daemon/ctl/dwell_follower.hpp"

#include <gtest/gtest.h>

#include "daemon/report/dwell_change.hpp"
#include "daemon/report/dwell_json.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell::ctl {
namespace {

DwellView view_of(const Dwell& dwell) { return make_view(dwell, test::sample_rig(), test::sample_run()); }

TEST(DwellFollower, PutsWholeAndChangesTogether) {
  Dwell dwell = test::sample_dwell();
  DwellFollower follower;
  const std::string whole = to_json(view_of(dwell));
  EXPECT_EQ(follower.take({"dwell", whole}), whole);
  for (int i = 0; i < 3; ++i) {
    const Json before = json_value(view_of(dwell));
    dwell.end_s += 0.1;
    dwell.elements[0].damping.value *= 1.001;
    const auto change = change_between(before, json_value(view_of(dwell)));
    ASSERT_TRUE(change);
    EXPECT_EQ(follower.take({"change", dump(*change)}), to_json(view_of(dwell)));
  }
}

TEST(DwellFollower, WaitsForAWholeWhereItHasNoneAndMindsNothingElse) {
  DwellFollower follower;
  const std::string change = R"({"index":1,"state":"measuring","end_s":3.0})";
  EXPECT_FALSE(follower.take({"change", change})) << "nothing to start from";
  EXPECT_FALSE(follower.take({"other", "{}"}));
  const std::string whole = to_json(view_of(test::sample_dwell()));
  EXPECT_TRUE(follower.take({"dwell", whole}));
  for (const char* junk : {"", "[", "null", R"({"index":99,"state":"measuring"})"})
    EXPECT_FALSE(follower.take({"change", junk})) << junk;
  EXPECT_EQ(follower.take({"dwell", "junk"}), "junk") << "whoever reads it says what is wrong with it";
  EXPECT_FALSE(follower.take({"change", change}));
}

}  // namespace
}  // namespace dwell::ctl
