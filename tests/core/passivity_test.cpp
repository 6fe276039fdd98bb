// Negative coefficients: what chance does, and what it does not.
#include "core/chain/passivity.hpp"

#include <gtest/gtest.h>

#include "tests/core/bench_rig.hpp"

namespace dwell {
namespace {

// Two masses, two elements. The damping of element 2 comes out as `damping`, U95 = 10 N·s/m.
struct Found {
  std::vector<ElementEstimate> elements;
  std::vector<Doubt> doubts;
};

Found with_damping(double damping) {
  const Rig rig = rig_of({Boundary::free, {1.0, 1.0}, {1e4, 1e4}, {1.0, 1.0}}, 4.0);
  Found found;
  for (int k = 1; k <= 2; ++k) {
    ElementEstimate element;
    element.k = k;
    element.identifiable = true;
    element.stiffness = {1e4, 5.0, INFINITY, 10.0, true};
    element.damping = {k == 2 ? damping : 50.0, 5.0, INFINITY, 10.0, true};
    found.elements.push_back(element);
  }
  const std::vector<std::vector<bool>> used{{true, true, true}, {false, true, true}};
  refuse_negative(rig, used, found.elements, found.doubts);
  return found;
}

TEST(Passivity, ADampingWithinItsUncertaintyOfZeroStays) {
  const Found found = with_damping(-9.0);
  EXPECT_TRUE(found.elements[1].identifiable);
  EXPECT_TRUE(found.doubts.empty());
}

TEST(Passivity, ADampingThatChanceMakesNegativeIsWithheldAndNothingElseIsBlamed) {
  const Found found = with_damping(-15.0);
  EXPECT_FALSE(found.elements[1].identifiable);
  EXPECT_NE(found.elements[1].reason.find("-15 ± 10 N·s/m"), std::string::npos) << found.elements[1].reason;
  ASSERT_EQ(found.doubts.size(), 1U);
  EXPECT_EQ(found.doubts[0].elements, std::vector<int>{2});
  EXPECT_TRUE(found.doubts[0].by_chance);
  EXPECT_EQ(found.doubts[0].what.find("y1"), std::string::npos) << found.doubts[0].what;
}

TEST(Passivity, ADampingThatNoChanceMakesNegativeCastsDoubtOnAllThatRestsOnItsChannels) {
  const Found found = with_damping(-25.0);
  EXPECT_FALSE(found.elements[1].identifiable);
  ASSERT_EQ(found.doubts.size(), 1U);
  EXPECT_EQ(found.doubts[0].elements, (std::vector<int>{1, 2}));
  EXPECT_FALSE(found.doubts[0].by_chance);
  EXPECT_NE(found.doubts[0].what.find("y1 and y2"), std::string::npos) << found.doubts[0].what;
  EXPECT_NE(found.doubts[0].what.find("element 1 rests"), std::string::npos) << found.doubts[0].what;
}

}  // namespace
}  // namespace dwell
