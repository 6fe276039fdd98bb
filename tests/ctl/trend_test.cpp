// How a coefficient has moved, as a line of blocks.
#include "daemon/ctl/trend.hpp"

#include <gtest/gtest.h>

#include "daemon/ctl/watch_page.hpp"
#include "daemon/report/number_text.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell::ctl {
namespace {

// The sample dwell with this stiffness of element 1 (U95 1 %) and so many seconds of data.
DwellView view_of(double stiffness, double data_s = 0.0) {
  Dwell dwell = test::sample_dwell();
  dwell.end_s = dwell.settled_s + data_s;
  dwell.elements[0].stiffness.value = stiffness;
  dwell.elements[0].stiffness.U95 = 10.0;
  return make_view(dwell, test::sample_rig(), test::sample_run());
}

std::string line_of_element_1(const Trend& trend, const DwellView& newest, double now_s) {
  const Section section = trend.section(newest, now_s, 80);
  return section.body.empty() ? "" : section.body[0].text.substr(0, section.body[0].text.find('%') + 1);
}

TEST(Sparkline, HasEightHeightsAboutItsMiddle) {
  EXPECT_EQ(sparkline({-1.0, -0.8, -0.6, -0.3, 0.1, 0.3, 0.6, 0.8, 1.0}, 0.0, 1.0), "▁▁▂▃▅▆▇██");
  EXPECT_EQ(sparkline({kNaN, 5.0, kNaN}, 5.0, 0.0), " ▅ ");
}

TEST(Trend, WhatStaysWithinItsU95StaysInTheMiddleHeights) {
  Trend trend;
  for (int i = 0; i <= 60; ++i) trend.take(view_of(i % 6 < 3 ? 1009.0 : 991.0), i);
  trend.take(view_of(1000.0), 60.0);
  const std::string line = line_of_element_1(trend, view_of(1000.0), 60.0);
  EXPECT_EQ(line, "      1  ▆▃▆▃▆▃▆▃▆▃▆▃▆▃▆▃▆▃▆▅  ± 2 %") << "half a height is 1 %: U95";
}

TEST(Trend, WhatWasFurtherAwayWidensTheHeight) {
  Trend trend;
  for (int i = 0; i < 30; ++i) trend.take(view_of(1100.0), i);
  for (int i = 30; i <= 60; ++i) trend.take(view_of(1000.0), i);
  EXPECT_EQ(line_of_element_1(trend, view_of(1000.0), 60.0), "      1  ██████████▅▅▅▅▅▅▅▅▅▅  ± 10 %");
}

TEST(Trend, IsBlankWhereNoCoefficientWasGiven) {
  Trend trend;
  const DwellView settling = make_view(test::settling_dwell(), test::sample_rig(), test::sample_run());
  for (int i = 0; i <= 60; ++i) trend.take(i >= 15 && i < 45 ? settling : view_of(1000.0), i);
  EXPECT_EQ(line_of_element_1(trend, view_of(1000.0), 60.0), "      1  ▅▅▅▅▅          ▅▅▅▅▅  ± 2 %");
  EXPECT_TRUE(trend.section(settling, 60.0, 80).body.empty()) << "no coefficients, no trend";
}

TEST(Trend, ADwellThatWatchFindsMeasuringBeganWithItsData) {
  Trend trend;
  for (int i = 0; i <= 3; ++i) trend.take(view_of(1000.0, 57.0 + i), 100.0 + i);
  EXPECT_EQ(line_of_element_1(trend, view_of(1000.0, 60.0), 103.0), "      1  ▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅  ± 2 %");
}

TEST(Trend, ADwellThatHasEndedAndStaysInViewIsNotDrawnOn) {
  Trend trend;
  DwellView ended = view_of(1000.0, 30.0);
  ended.dwell.state = State::complete;
  for (int i = 0; i <= 60; ++i) trend.take(i <= 30 ? view_of(1000.0, i) : ended, i);
  EXPECT_EQ(line_of_element_1(trend, ended, 60.0), "      1  ▅▅▅▅▅▅▅▅▅▅▅           ± 2 %");
}

TEST(Trend, EarlierDwellsStandFromTheirFirstToTheirLastDatum) {
  Trend trend;
  trend.take(view_of(1000.0), 1000.0);
  trend.take(view_of(1000.0), 1001.0);
  trend.take_earlier({{1, 601.0, 451.0, {1100.0}, {}}, {2, 301.0, 151.0, {900.0}, {}}}, 1001.0);
  EXPECT_EQ(line_of_element_1(trend, view_of(1000.0), 1001.0), "      1  █████    ▁▁▁▁▁▁    ▅  ± 10 %");
  EXPECT_EQ(trend.section(view_of(1000.0), 1001.0, 80).head[0].text.substr(0, 24), "trend of the last 601 s;");
}

TEST(Trend, IsBlankWhereTheConnectionWasLostAmidADwell) {
  Trend trend;
  for (int i = 0; i <= 20; ++i) trend.take(view_of(1000.0, 100.0 + i), 100.0 + i);
  for (int i = 100; i <= 101; ++i) trend.take(view_of(1000.0, 100.0 + i), 100.0 + i);
  EXPECT_EQ(line_of_element_1(trend, view_of(1000.0, 200.0), 201.0), "      1  ▅▅▅▅▅▅▅▅▅▅▅▅       ▅  ± 2 %");
}

TEST(Trend, IsBlankWhereTheEstimationTellsTheSameAgain) {
  Trend trend;
  for (int i = 0; i <= 60; ++i) {
    DwellView view = view_of(1000.0, std::min(i, 30));
    view.age = LiveAge{std::max(0.0, i - 30.0), i > 33};
    trend.take(view, i);
  }
  EXPECT_EQ(line_of_element_1(trend, view_of(1000.0, 30.0), 60.0), "      1  ▅▅▅▅▅▅▅▅▅▅▅▅          ± 2 %");
}

TEST(Trend, DwellsThatEndedWhileTheConnectionWasLostStandWhereTheyWere) {
  Trend trend;
  // Dwell 1 is seen for 30 s of its 90, dwell 2 ends unseen as well, dwell 3 is found measuring.
  for (int i = 0; i <= 30; ++i) trend.take(view_of(1000.0, i), 100.0 + i);
  Dwell third = test::sample_dwell();
  third.index = 3;
  third.end_s = third.settled_s + 30.0;
  third.elements[0].stiffness.value = 1000.0;
  third.elements[0].stiffness.U95 = 10.0;
  const DwellView now = make_view(third, test::sample_rig(), test::sample_run());
  trend.take(now, 300.0);
  const std::vector<EarlierDwell> ended = {{1, 200.0, 110.0, {1100.0}, {}}, {2, 100.0, 50.0, {900.0}, {}}};
  trend.take_earlier(ended, 300.0);
  const std::string line = line_of_element_1(trend, now, 300.0);
  EXPECT_EQ(line, "      1  ▅▅▅███████▁▁▁▁▁▁ ▅▅▅  ± 10 %");
  trend.take_earlier(ended, 300.1);
  EXPECT_EQ(line_of_element_1(trend, now, 300.0), line) << "told again, as after the next loss";
}

TEST(Trend, OfEarlierDwellsThoseOfTheLastHourAreKept) {
  Trend trend;
  trend.take(view_of(1000.0), 9000.0);
  trend.take_earlier({{1, 4000.0, 3601.0, {2000.0}, {}}, {2, 3000.0, 2999.0, {1000.0}, {}}}, 9000.0);
  EXPECT_EQ(line_of_element_1(trend, view_of(1000.0), 9000.0).substr(0, 12), "      1  ▅");
}

TEST(Trend, ReachesBackAnHourAndNoFurther) {
  Trend trend;
  for (int i = 0; i < 7200; ++i) trend.take(view_of(i < 3000 ? 2000.0 : 1000.0), i);
  const Section section = trend.section(view_of(1000.0), 7199.0, 80);
  EXPECT_NE(section.head[0].text.find("trend of the last 59 min"), std::string::npos) << section.head[0].text;
  EXPECT_EQ(line_of_element_1(trend, view_of(1000.0), 7199.0), "      1  ▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅  ± 2 %");
}

TEST(Trend, FitsItsColumns) {
  Trend trend;
  for (int i = 0; i <= 60; ++i) trend.take(view_of(1000.0), i);
  for (const std::size_t columns : {40U, 79U, 80U, 200U}) {
    const Section section = trend.section(view_of(1000.0), 60.0, columns);
    EXPECT_EQ(section.body.size(), columns < 80 ? 4U : 2U) << "elements 1 and 3 are identifiable";
    for (const std::vector<TextLine>* lines : {&section.head, &section.body})
      for (const TextLine& line : *lines) EXPECT_LE(width(line.text), columns) << line.text;
  }
}

TEST(Trend, StandsBelowTheCoefficientsAndTheVerdictInTheFirstLines) {
  WatchState state;
  for (int i = 0; i <= 60; ++i) {
    DwellView view = view_of(1000.0);
    view.model = ModelVerdict{Verdict::not_adequate, true, 0.05, 0.08, 0.01};
    state.take(std::move(view), i);
  }
  const Page page = draw(state, {}, nullptr, {24, 80}, 60.0, "14:03:22");
  EXPECT_NE(page.lines[1].text.find("· model not adequate"), std::string::npos) << page.lines[1].text;
  std::size_t coefficients = 0, trend = 0;
  for (std::size_t i = 0; i < page.lines.size(); ++i) {
    if (page.lines[i].text.find(" ± ") != std::string::npos && coefficients == 0) coefficients = i;
    if (page.lines[i].text.find("trend of the last") != std::string::npos) trend = i;
  }
  EXPECT_GT(coefficients, 0U);
  EXPECT_GT(trend, coefficients);
}

}  // namespace
}  // namespace dwell::ctl
