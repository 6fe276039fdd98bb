#include "core/base/wording.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell {
namespace {

TEST(Wording, ShowsNumbersToTheDigitsTheyHave) {
  EXPECT_EQ(brief(16.6432), "16.6");
  EXPECT_EQ(brief(0.25), "0.25");
  EXPECT_EQ(brief(-4.244), "-4.24");
  EXPECT_EQ(brief(0), "0");
  EXPECT_EQ(brief(123456), "123000");
  EXPECT_EQ(brief(1.234e7), "1.23e+07");
  EXPECT_EQ(brief(1.2e-5), "1.20e-05");
  EXPECT_EQ(brief(std::nan("")), "—");
}

TEST(Wording, MatchesAValueToItsUncertainty) {
  EXPECT_EQ(plus_minus(-11402.3, 253, "N/m"), "-11400 ± 250 N/m");
  EXPECT_EQ(plus_minus(-0.5678, 0.0312, "N·s/m"), "-0.568 ± 0.031 N·s/m");
  EXPECT_EQ(plus_minus(-3.2, 1.96, "N·s/m"), "-3.2 ± 2.0 N·s/m");
  EXPECT_EQ(plus_minus(2.8e-14, 0.0351, "N"), "0.000 ± 0.035 N");
  EXPECT_EQ(plus_minus(1.5, 3.1e-8, "N"), "1.500000000 ± 0.000000031 N");
  EXPECT_EQ(plus_minus(-2.5e9, 1.2e7, "N/m"), "-2.500e+09 ± 1.2e+07 N/m");
  EXPECT_EQ(plus_minus(5, std::nan(""), "N"), "5 ± — N");
}

TEST(Wording, UnitsAreSpeltAsInTables) {
  EXPECT_EQ(unit_text("N*m"), "N·m");
  EXPECT_EQ(unit_text("mm"), "mm");
}

TEST(Wording, ListsNamesAndElements) {
  EXPECT_EQ(listed({}), "");
  EXPECT_EQ(listed({"y1"}), "y1");
  EXPECT_EQ(listed({"y1", "y2", "reaction"}), "y1, y2 and reaction");
  EXPECT_EQ(elements_text({2}), "element 2");
  EXPECT_EQ(elements_text({1, 3}), "elements 1 and 3");
  EXPECT_EQ(elements_text({}), "no element");
}

}  // namespace
}  // namespace dwell
