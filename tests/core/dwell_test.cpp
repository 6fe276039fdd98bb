#include "core/result/dwell.hpp"

#include <gtest/gtest.h>

namespace dwell {
namespace {

TEST(Dwell, IsTrustworthyOnlySettledWithEveryElementAndWithoutDoubts) {
  Dwell dwell;
  EXPECT_FALSE(trustworthy(dwell));
  dwell.settled_s = 1.0;
  EXPECT_FALSE(trustworthy(dwell)) << "no elements";
  dwell.elements.resize(2);
  dwell.elements[0].identifiable = true;
  EXPECT_FALSE(trustworthy(dwell)) << "one element is withheld";
  dwell.elements[1].identifiable = true;
  EXPECT_TRUE(trustworthy(dwell));
  dwell.doubts.push_back({{1}, "negative stiffness"});
  EXPECT_FALSE(trustworthy(dwell));
  dwell.doubts.clear();
  dwell.settled_s = kNaN;
  EXPECT_FALSE(trustworthy(dwell)) << "not settled";
}

}  // namespace
}  // namespace dwell
