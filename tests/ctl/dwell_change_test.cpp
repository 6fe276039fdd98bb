#include "daemon/report/dwell_change.hpp"

#include <gtest/gtest.h>

#include "daemon/report/dwell_json.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell {
namespace {

DwellView view_of(const Dwell& dwell) { return make_view(dwell, test::sample_rig(), test::sample_run()); }

// A publication later: every kind of member has moved.
Dwell moved(Dwell dwell) {
  dwell.end_s += 0.1;
  dwell.frequency_hz.u *= 0.99;
  dwell.phasors[0].Y *= 1.0001;
  dwell.phasors[0].harmonics.assign(2, 1e-3);
  dwell.elements[0].stiffness.value += 0.5;
  dwell.elements[0].budget[0].damping_share *= 0.5;
  dwell.covariance[0] *= 1.1;
  dwell.warnings.push_back({WarningKind::unsteady, "y1 is not steady"});
  return dwell;
}

TEST(DwellChange, AppliedToTheWholeGivesTheNextWholeButForWhatIsLeftOut) {
  const Dwell before = test::sample_dwell();
  const Dwell now = moved(before);
  const auto change = change_between(json_value(view_of(before)), json_value(view_of(now)));
  ASSERT_TRUE(change);
  Json whole = json_value(view_of(before));
  ASSERT_TRUE(apply_change(whole, *change)) << change->dump(1);
  Json expected = json_value(view_of(now));
  expected["covariance"] = whole["covariance"];
  expected["elements"][0]["budget"] = whole["elements"][0]["budget"];
  EXPECT_EQ(whole, expected);
}

TEST(DwellChange, HoldsOnlyWhatMovedAndWhoseItIs) {
  const Json before = json_value(view_of(test::sample_dwell()));
  Dwell dwell = test::sample_dwell();
  dwell.elements[0].stiffness.value += 0.5;
  const auto change = change_between(before, json_value(view_of(dwell)));
  ASSERT_TRUE(change);
  const Json expected = {{"index", *dwell.index},
                         {"state", "measuring"},
                         {"elements", {{{"k", 1}, {"stiffness", {{"value", dwell.elements[0].stiffness.value}}}}}}};
  EXPECT_EQ(*change, expected) << change->dump(1);
}

TEST(DwellChange, IsTheSameWithoutCovarianceAndBudgets) {
  const Dwell before = test::sample_dwell();
  const Dwell now = moved(before);
  EXPECT_EQ(change_between(json_value(view_of(before)), json_value(view_of(now))),
            change_between(json_value(view_of(before), Detail::moving), json_value(view_of(now), Detail::moving)));
}

TEST(DwellChange, AnotherDwellStateOrShapeNeedsTheWhole) {
  const Dwell before = test::sample_dwell();
  const auto needs_whole = [&before](auto alter) {
    Dwell now = before;
    alter(now);
    return !change_between(json_value(view_of(before)), json_value(view_of(now)));
  };
  EXPECT_FALSE(needs_whole([](Dwell&) {}));
  EXPECT_TRUE(needs_whole([](Dwell& d) { d.index = *d.index + 1; }));
  EXPECT_TRUE(needs_whole([](Dwell& d) { d.state = State::complete; }));
  EXPECT_TRUE(needs_whole([](Dwell& d) { d.settled_s += 1.0; }));
  EXPECT_TRUE(needs_whole([](Dwell& d) { d.elements.pop_back(); }));
  EXPECT_TRUE(needs_whole([](Dwell& d) { d.elements[0].identifiable = false; }));
}

TEST(DwellChange, OfAnotherDwellOrOutOfShapeIsNotApplied) {
  Json whole = json_value(view_of(test::sample_dwell()));
  const Json before = whole;
  const int index = *test::sample_dwell().index;
  for (const Json& wrong :
       {Json(), Json::array(), Json::object(), Json{{"index", index + 1}, {"state", "measuring"}, {"end_s", 1.0}},
        Json{{"index", index}, {"state", "settling"}, {"end_s", 1.0}},
        Json{{"index", index}, {"state", "measuring"}, {"no_such", 1.0}},
        Json{{"index", index}, {"state", "measuring"}, {"elements", {{{"k", 77}}}}},
        Json{{"index", index}, {"state", "measuring"}, {"elements", 3}},
        Json{{"index", index}, {"state", "measuring"}, {"end_s", 1.0}, {"phasors", {nullptr}}}}) {
    EXPECT_FALSE(apply_change(whole, wrong)) << wrong.dump();
    EXPECT_EQ(whole, before);
  }
  Json nothing;
  EXPECT_FALSE(apply_change(nothing, Json{{"index", index}, {"state", "measuring"}}));
}

}  // namespace
}  // namespace dwell
