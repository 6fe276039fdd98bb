// Limits of the rig file in the dwell object and in texts for people.
#include "daemon/report/limit_text.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/report/dwell_json.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell {
namespace {

// c_1 24010 ± 27, r_1 60.20 ± 0.79; element 2 not identifiable; c_3 1.23 MN/m.
DwellView limited() {
  Rig rig = test::sample_rig();
  rig.limits = {{1, Bounds{23e3, 24e3}, Bounds{40.0, 70.0}},
                {2, Bounds{1.0, 2.0}, std::nullopt},
                {3, Bounds{1e6, 1.1e6}, Bounds{0.0, 10.0}}};
  return make_view(test::sample_dwell(), rig, test::sample_run());
}

std::vector<std::string> lines_of(const Section& section) {
  std::vector<std::string> lines;
  for (const TextLine& line : section.body) lines.push_back(line.text);
  return lines;
}

TEST(LimitText, TheViolatedComeFirstAndThoseAloneAreLoud) {
  const Section section = limit_section(limited(), {});
  EXPECT_EQ(lines_of(section),
            (std::vector<std::string>{
                "limits     violated: stiffness of element 3 is 1.23457 ± 0.00020 MN/m, outside 1.000 "
                "to 1.100 MN/m",
                "limits     undecided: ± of the stiffness of element 1 reaches over an end of 23.00 "
                "to 24.00 kN/m",
                "limits     undecided: ± of the damping of element 3 reaches over an end of 0 to "
                "10.00 N·s/m",
                "limits     kept: damping of element 1, 40.00 to 70.00 N·s/m",
                "limits     no verdict on stiffness of element 2: the deformation is less than "
                "three times its uncertainty",
            }));
  for (const TextLine& line : section.body)
    EXPECT_EQ(line.style == Style::alarm, line.text.find("violated") != std::string::npos) << line.text;
}

TEST(LimitText, ADoubtThatTakesALimitItsVerdictIsNotToldOnceMore) {
  Rig rig = test::sample_rig();
  rig.limits = {{1, Bounds{23e3, 24e3}, std::nullopt}};
  Dwell dwell = test::sample_dwell();
  dwell.doubts = {{{}, "mode at 4.77 Hz"}};
  EXPECT_EQ(
      lines_of(limit_section(make_view(dwell, rig, test::sample_run()), {})),
      (std::vector<std::string>{"limits     no verdict on stiffness of element 1: the number must not be relied on"}));
}

TEST(LimitText, ABoundHasAsManyDigitsAsItTakesToBeIt) {
  JudgedLimit limit;
  limit.bounds = {8000.4, 8499.9};
  EXPECT_EQ(bounds_text(limit, Motion::translation), "8.0004 to 8.4999 kN/m");
  limit.bounds = {1.0 / 3.0, 123456.78901};
  EXPECT_EQ(bounds_text(limit, Motion::translation), "333.333333333333 mN/m to 123.45678901 kN/m");
  limit.bounds = {-50.0, 0.0};
  EXPECT_EQ(bounds_text(limit, Motion::translation), "-50.00 to 0 N/m");
}

TEST(LimitText, OfOneEndSaysOnWhichSideItIs) {
  Rig rig = test::sample_rig();
  rig.limits = {{1, Bounds{-INFINITY, 23e3}, Bounds{40.0, INFINITY}}, {3, std::nullopt, Bounds{0.5, INFINITY}}};
  EXPECT_EQ(lines_of(limit_section(make_view(test::sample_dwell(), rig, test::sample_run()), {})),
            (std::vector<std::string>{
                "limits     violated: stiffness of element 1 is 24.010 ± 0.027 kN/m, not at most 23.00 kN/m",
                "limits     undecided: ± of the damping of element 3 reaches over 500.0 mN·s/m",
                "limits     kept: damping of element 1, at least 40.00 N·s/m",
            }));
}

TEST(LimitText, OldVerdictsAreGreyAsTheirNumbers) {
  TextOptions options;
  options.age = "12 s";
  for (const TextLine& line : limit_section(limited(), options).body) EXPECT_EQ(line.style, Style::old);
}

TEST(LimitText, NothingIsSaidBeforeADwellHasSettledAndOfARigWithoutLimits) {
  DwellView view = limited();
  view.dwell.elements.clear();
  EXPECT_TRUE(limit_section(view, {}).body.empty());
  EXPECT_TRUE(limit_section(make_view(test::sample_dwell(), test::sample_rig(), {}), {}).body.empty());
}

TEST(LimitJson, VerdictsSurviveTheWayThereAndBack) {
  const DwellView view = limited();
  const auto back = parse_dwell(to_json(view));
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ(to_json(*back), to_json(view));
  ASSERT_EQ(back->limits.size(), 5u);
  EXPECT_EQ(back->limits[3].verdict, LimitVerdict::violated);
  EXPECT_EQ(back->limits[2].reason, "the deformation is less than three times its uncertainty");
}

TEST(LimitJson, AnOpenEndSurvivesTheWayThereAndBack) {
  Rig rig = test::sample_rig();
  rig.limits = {{1, Bounds{-INFINITY, 23e3}, Bounds{40.0, INFINITY}}};
  const std::string text = to_json(test::sample_dwell(), rig, test::sample_run());
  EXPECT_NE(text.find("\"low\":null,\"high\":23000.0"), std::string::npos) << text;
  const auto back = parse_dwell(text);
  ASSERT_TRUE(back) << back.error();
  ASSERT_EQ(back->limits.size(), 2u);
  EXPECT_EQ(back->limits[0].bounds.low, -INFINITY);
  EXPECT_EQ(back->limits[0].bounds.high, 23e3);
  EXPECT_EQ(back->limits[1].bounds.low, 40.0);
  EXPECT_EQ(back->limits[1].bounds.high, INFINITY);
}

TEST(LimitJson, OfARigWithoutLimitsTheObjectIsAsBeforeThereWereAny) {
  const std::string text = to_json(test::sample_dwell(), test::sample_rig(), test::sample_run());
  EXPECT_EQ(text.find("limits"), std::string::npos);
}

}  // namespace
}  // namespace dwell
