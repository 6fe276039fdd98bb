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
Dwell dwell_of(int index, double stiffness, double damping = 60.0) {
  Dwell dwell = test::sample_dwell();
  dwell.index = index;
  dwell.elements.resize(1);
  dwell.elements[0].stiffness.value = stiffness;
  dwell.elements[0].stiffness.U95 = 3.0;
  dwell.elements[0].damping.value = damping;
  dwell.elements[0].damping.U95 = 0.5;
  return dwell;
}

DwellView view_of(const Dwell& dwell, const Dwell& before, std::string run = test::sample_run().start_utc) {
  DwellView view = make_view(dwell, test::sample_rig(), test::sample_run());
  view.since = SinceBefore{before.index.value_or(0), std::move(run), before.end_s, moves_since(before, dwell)};
  return view;
}

std::string text_of(const DwellView& view, double before_ago_s = kNaN) {
  const Section section = deviation_section(view, before_ago_s, 80);
  std::string text;
  for (const std::vector<TextLine>* lines : {&section.head, &section.body})
    for (const TextLine& line : *lines) text += line.text + "\n";
  return text;
}

TEST(Deviation, IsStatedWithTheU95OfBothAndSaysWhatIsBeyondIt) {
  const DwellView now = view_of(dwell_of(2, 1010.0, 59.7), dwell_of(1, 1000.0));
  EXPECT_EQ(text_of(now), R"(change since dwell 1; moved: by more than chance (one false alarm in 20 dwells)
element  stiffness                         damping
      1  +1.00 ± 0.42 % moved              -0.5 ± 1.2 %
)");
  EXPECT_EQ(deviation_section(now, kNaN, 80).body[0].style, Style::title) << "bold: it has moved";
}

TEST(Deviation, WithoutADwellBeforeThereIsNone) {
  EXPECT_EQ(text_of(make_view(dwell_of(1, 1000.0), test::sample_rig(), test::sample_run())), "");
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
  EXPECT_EQ(moved_beyond(dwell_of(1, 1000.0)), moved_beyond(2)) << "one element";
  EXPECT_TRUE(std::isnan(moved_beyond(test::settling_dwell())));
}

TEST(Deviation, IsAPartOfTheValueBeforeAndCountsTheU95OfBoth) {
  Dwell before = dwell_of(1, -1000.0), now = dwell_of(2, -1010.0);
  before.elements[0].stiffness.U95 = 4.0;
  const auto moves = moves_since(before, now);
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_EQ(moves[0].k, 1);
  EXPECT_DOUBLE_EQ(moves[0].stiffness.change, -0.01);
  EXPECT_DOUBLE_EQ(moves[0].stiffness.U95, 0.005);
  EXPECT_TRUE(moves[0].stiffness.moved);
  EXPECT_EQ(moves[0].damping.change, 0.0);
  EXPECT_FALSE(moves[0].damping.moved);
  now.elements[0].stiffness.value = -1000.0 - 0.99 * moved_beyond(2) * 5.0;
  EXPECT_FALSE(moves_since(before, now)[0].stiffness.moved)
      << "a change that chance may make in one of two coefficients";
}

TEST(Deviation, WhatRoundsToZeroHasNoSign) {
  const std::string text = text_of(view_of(dwell_of(2, 1000.0), dwell_of(1, 1000.0)));
  EXPECT_NE(text.find("      1  0.00 ± 0.42 %                     0.0 ± 1.2 %\n"), std::string::npos) << text;
}

TEST(Deviation, ADwellOfAnEarlierRunIsNamedAsOne) {
  const DwellView now = view_of(dwell_of(1, 1000.0), dwell_of(1, 990.0), "2026-11-22T06:00:00Z");
  EXPECT_EQ(text_of(now, 780.0).substr(0, 53), "change since dwell 1 of an earlier run, 780 s ago; mo");
  EXPECT_EQ(text_of(now).substr(0, 44), "change since dwell 1 of an earlier run; move");
}

TEST(Deviation, ADwellWithoutANumberSaysThatThereIsNothingToCompareWith) {
  EXPECT_EQ(text_of(view_of(dwell_of(2, 1000.0), dwell_of(1, kNaN))),
            R"(change since dwell 1; —: dwell 1 has no number to compare with
element  stiffness                         damping
      1  —                                 0.0 ± 1.2 %
)");
  Dwell withheld = dwell_of(1, 1000.0);
  withheld.elements[0].identifiable = false;
  EXPECT_TRUE(std::isnan(moves_since(withheld, dwell_of(2, 1000.0))[0].stiffness.change));
}

TEST(Deviation, FitsItsColumns) {
  for (const std::size_t columns : {40U, 79U, 80U}) {
    const Section section = deviation_section(view_of(dwell_of(2, 1010.0, 70.0), dwell_of(1, 1000.0)), kNaN, columns);
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
  Dwell before;
  for (int t = 0; t <= 60; ++t) {
    DwellView view = test::chain(2);
    view.dwell.index = t < 30 ? 1 : 2;
    view.dwell.end_s += t - 60;
    view.limits = {{1, CoefficientKind::stiffness, {7.5e3, 8.5e3}, LimitVerdict::violated, ""}};
    view.dwell.elements[0].stiffness.value += t < 30 ? 0.0 : 240.0;
    view.model = ModelVerdict{Verdict::adequate, true, 0.05, 0.01, 0.004};
    if (t < 30)
      before = view.dwell;
    else
      view.since = SinceBefore{1, view.run.start_utc, before.end_s, moves_since(before, view.dwell)};
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
  state.take_last(last);
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
      EXPECT_EQ(line.style, Style::past) << line.text;
    }
  }
  state.take(test::chain(2), 102.0);
  EXPECT_EQ(test::text_of(test::at(state, {}, test::kUsual, 102.1)).find("not of now"), std::string::npos);
}

}  // namespace
}  // namespace dwell::ctl
