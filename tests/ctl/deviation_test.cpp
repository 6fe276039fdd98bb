// How each coefficient differs from that of the dwell before.
#include "daemon/ctl/deviation.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "core/result/moved.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/number_text.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/ctl/watched.hpp"

namespace dwell::ctl {
namespace {

// The dwell of this index, with this stiffness of element 1 (U95 3 N/m) and this damping (U95 0.5 N·s/m).
DwellView view_of(int index, double stiffness, double damping = 60.0, State state = State::measuring) {
  Dwell dwell = test::sample_dwell();
  dwell.index = index;
  dwell.state = state;
  dwell.elements.resize(1);
  dwell.elements[0].stiffness.value = stiffness;
  dwell.elements[0].stiffness.U95 = 3.0;
  dwell.elements[0].damping.value = damping;
  dwell.elements[0].damping.U95 = 0.5;
  return make_view(dwell, test::sample_rig(), test::sample_run());
}

EarlierDwell ended(int index, double ago_s, double stiffness, std::string run = test::sample_run().start_utc) {
  return {index, ago_s + 30.0, ago_s, {stiffness}, {60.0}, {4.0}, {0.5}, std::move(run)};
}

std::string text_of(const Deviation& deviation, const DwellView& view, double now_s = 100.0) {
  const Section section = deviation.section(view, now_s, 80);
  std::string text;
  for (const std::vector<TextLine>* lines : {&section.head, &section.body})
    for (const TextLine& line : *lines) text += line.text + "\n";
  return text;
}

TEST(Deviation, IsStatedWithTheU95OfBothAndSaysWhatIsBeyondIt) {
  Deviation deviation;
  deviation.take(view_of(1, 1000.0), 10.0);
  EXPECT_EQ(text_of(deviation, view_of(1, 1000.0)), "") << "there is no dwell before";
  const DwellView now = view_of(2, 1010.0, 59.7);
  deviation.take(now, 50.0);
  EXPECT_EQ(text_of(deviation, now), R"(change since dwell 1; moved: by more than chance (one false alarm in 20 dwells)
element  stiffness                         damping
      1  +1.00 ± 0.42 % moved              -0.5 ± 1.2 %
)");
  EXPECT_EQ(deviation.section(now, 50.0, 80).body[0].style, Style::title) << "bold: it has moved";
}

// At the level of one coefficient, among eight of them one moved in a third of the dwells.
TEST(Deviation, ChanceMovesAnyOfEightCoefficientsInOneDwellOf20) {
  std::mt19937_64 random(13);
  std::normal_distribution<double> noise;
  constexpr int kDwells = 40'000;
  int at_one_level = 0, at_that_of_all = 0;
  for (int i = 0; i < kDwells; ++i) {
    double largest = 0.0;  // difference over √(U95² + U95²)
    for (int k = 0; k < 8; ++k)
      largest = std::max(largest, std::abs(noise(random) - noise(random)) / (kNormal95 * std::sqrt(2.0)));
    at_one_level += largest > 1.0 ? 1 : 0;
    at_that_of_all += largest > moved_beyond(8) ? 1 : 0;
  }
  EXPECT_NEAR(at_one_level / double{kDwells}, 0.337, 0.01);
  EXPECT_NEAR(at_that_of_all / double{kDwells}, 0.05, 0.005) << "4.6 standard deviations of so many draws";
}

TEST(Deviation, CountsTheCoefficientsThatHaveNumbers) {
  EXPECT_EQ(moved_beyond(1), 1.0);
  EXPECT_NEAR(moved_beyond(2), 2.236477 / kNormal95, 1e-6);
  EXPECT_NEAR(moved_beyond(200), 3.655748 / kNormal95, 1e-6);
  EXPECT_EQ(moved_beyond(view_of(1, 1000.0).dwell), moved_beyond(2)) << "one element";
  EXPECT_TRUE(std::isnan(moved_beyond(test::settling_dwell())));
}

TEST(Deviation, WhatRoundsToZeroHasNoSign) {
  Deviation deviation;
  deviation.take(view_of(1, 1000.0), 10.0);
  EXPECT_NE(text_of(deviation, view_of(2, 1000.0)).find("      1  0.00 ± 0.42 %                     0.0 ± 1.2 %\n"),
            std::string::npos)
      << text_of(deviation, view_of(2, 1000.0));
}

TEST(Deviation, TheEndOfADwellReplacesWhatWasToldLive) {
  Deviation deviation;
  deviation.take(view_of(1, 1200.0), 10.0);  // the drive had stopped already
  const DwellView now = view_of(2, 1010.0);
  deviation.take(now, 50.0);
  deviation.take_earlier({ended(1, 45.0, 1010.0)}, 50.0);
  EXPECT_NE(text_of(deviation, now).find("0.00 ± 0.50 %"), std::string::npos) << text_of(deviation, now);
  deviation.take(now, 51.0);
  EXPECT_NE(text_of(deviation, now).find("0.00 ± 0.50 %"), std::string::npos) << "and it stays";
}

TEST(Deviation, OfManyDwellsTheNewestBeforeCounts) {
  Deviation deviation;
  const DwellView now = view_of(4, 1000.0);
  deviation.take(now, 100.0);
  deviation.take_earlier({ended(1, 90.0, 900.0), ended(2, 60.0, 950.0), ended(3, 30.0, 990.0)}, 100.0);
  EXPECT_EQ(text_of(deviation, now).substr(0, 20), "change since dwell 3");
}

TEST(Deviation, ADwellOfAnEarlierRunIsNamedAsOne) {
  Deviation deviation;
  const DwellView now = view_of(1, 1000.0);
  deviation.take(now, 1000.0);
  deviation.take_earlier({ended(1, 780.0, 990.0, "2026-11-22T06:00:00Z")}, 1000.0);
  EXPECT_EQ(text_of(deviation, now, 1000.0).substr(0, 53), "change since dwell 1 of an earlier run, 780 s ago; mo");
}

TEST(Deviation, ADwellWithoutANumberSaysThatThereIsNothingToCompareWith) {
  Deviation deviation;
  const DwellView now = view_of(2, 1000.0);
  deviation.take(now, 50.0);
  deviation.take_earlier({ended(1, 45.0, kNaN)}, 50.0);
  EXPECT_EQ(text_of(deviation, now), R"(change since dwell 1; —: dwell 1 has no number to compare with
element  stiffness                         damping
      1  —                                 0.0 ± 1.2 %
)");
}

TEST(Deviation, ADwellThatHasEndedOrHasNotSettledIsNotCompared) {
  Deviation deviation;
  deviation.take(view_of(1, 1000.0), 10.0);
  EXPECT_EQ(text_of(deviation, view_of(2, 1010.0, 60.0, State::complete)), "");
  EXPECT_EQ(text_of(deviation, make_view(test::settling_dwell(), test::sample_rig(), test::sample_run())), "");
}

TEST(Deviation, FitsItsColumns) {
  Deviation deviation;
  deviation.take(view_of(1, 1000.0), 10.0);
  for (const std::size_t columns : {40U, 79U, 80U}) {
    const Section section = deviation.section(view_of(2, 1010.0, 70.0), 50.0, columns);
    for (const std::vector<TextLine>* lines : {&section.head, &section.body})
      for (const TextLine& line : *lines) EXPECT_LE(width(line.text), columns) << line.text;
    EXPECT_EQ(section.body.size(), columns < 80 ? 2U : 1U);
  }
}

// State, run, frequency, since; coefficients, trend, deviation, limits: as on the page.
TEST(WatchPage, ShowsWhatThePageShowsInItsOrder) {
  ::setenv("TZ", "UTC", 1);
  WatchState state;
  state.name = "bench 2";
  for (int t = 0; t <= 60; ++t) {
    DwellView view = test::chain(2);
    view.dwell.index = t < 30 ? 1 : 2;
    view.dwell.end_s += t - 60;
    view.limits = {{1, CoefficientKind::stiffness, {7.5e3, 8.5e3}, LimitVerdict::violated, ""}};
    view.dwell.elements[0].stiffness.value += t < 30 ? 0.0 : 240.0;
    view.model = ModelVerdict{Verdict::adequate, true, 0.05, 0.01, 0.004};
    state.take(std::move(view), t);
  }
  state.take_run("run 17, “rubber 3”");
  state.take_utc(*record::parse_utc(test::sample_run().start_utc) + 31'000'000'000, 60.0);
  const std::string text = test::text_of(draw(state, {}, nullptr, {24, 80}, 60.1, "14:03:22"));
  EXPECT_EQ(text.substr(0, text.find("\n\n\n")),
            R"(bench 2                                                     age 0.1 s · 14:03:22
dwell 2 · measuring, 24.6 s of data · model adequate
run 17, “rubber 3” · 4.000300 ± 0.000039 Hz · since 08:00:07 (24 s)

element  stiffness            damping             most of u²(c)
      1  24.251 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      2  24.012 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1

trend of the last 60 s; middle: newest value, height: ± the % beside
element  stiffness                         damping
      1  ▁▁▁▁▁▁▁▁▁▅▅▅▅▅▅▅▅▅▅▅  ± 0.99 %    ▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅  ± 2.6 %
      2  ▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅  ± 0.23 %    ▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅▅  ± 2.6 %
change since dwell 1; moved: by more than chance (one false alarm in 20 dwells)
      1  +1.00 ± 0.16 % moved              0.0 ± 1.9 %
      2   0.00 ± 0.16 %                    0.0 ± 1.9 %

limits     violated: stiffness of element 1 is 24.251 ± 0.027 kN/m, outside
           7.500 to 8.500 kN/m
± is the half width of the 95 % interval, if the rig is as its file says)");
}

// Idle with an empty screen, an operator would have to look for the result elsewhere.
TEST(WatchPage, TheLastDwellStaysAsAResultWhileThereIsNone) {
  WatchState state = test::watched(test::chain(2));
  Dwell idle;
  idle.state = State::idle;
  idle.settling_reason = "the table does not move";
  state.take(make_view(idle, test::sample_rig(), test::sample_run()), 101.0);
  EXPECT_NE(test::text_of(test::at(state, {}, test::kUsual, 101.1)).find("not of now · last dwell: 1\n"),
            std::string::npos)
      << "as told live";
  DwellView last = test::chain(2);
  last.dwell.state = State::complete;
  last.dwell.ended_by = EndedBy::drive_stopped;
  last.dwell.elements[1].identifiable = false;
  last.dwell.elements[1].reason = "y2 is stuck";
  last.dwell.doubts = {{{1}, "the chain does not fit"}};
  state.take_last(last, 101.1);
  state.take_utc(*record::parse_utc(test::sample_run().start_utc) + 43'000'000'000, 101.1);
  const Page page = test::at(state, {}, test::kUsual, 101.1);
  const std::string text = test::text_of(page);
  EXPECT_NE(text.find(R"(not of now · last dwell: 1, ended 12 s ago: drive stopped; do not rely on
  element 1: the chain does not fit
element   age  stiffness              damping               most of u²(c)
      1  12 s  24.011 ± 0.027 kN/m ?  60.20 ± 0.79 N·s/m ?  60 % scale of y1
      2  12 s       —                     —                 —
element 2 is not identifiable: y2 is stuck
)"),
            std::string::npos)
      << text;
  for (const TextLine& line : page.lines) {
    if (line.text.find("kN/m") != std::string::npos) {
      EXPECT_EQ(line.style, Style::old) << line.text;
    }
  }
  state.take(test::chain(2), 102.0);
  EXPECT_EQ(test::text_of(test::at(state, {}, test::kUsual, 102.1)).find("not of now"), std::string::npos);
}

}  // namespace
}  // namespace dwell::ctl
