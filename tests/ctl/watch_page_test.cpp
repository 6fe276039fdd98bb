// The screen of watch, exactly: what an operator sees on terminals of several sizes.
#include "daemon/ctl/watch_page.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "daemon/record/utc_text.hpp"
#include "daemon/report/number_text.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/ctl/watched.hpp"

namespace dwell::ctl {
namespace {

using test::all_pages, test::at, test::chain, test::kUsual, test::text_of, test::watched;

TEST(WatchPage, AUsualRigStandsOnOneScreenOf80By24) {
  EXPECT_EQ(text_of(at(watched(chain(4)), {}, kUsual)),
            R"(bench 2                                                     age 0.1 s · 14:03:22
dwell 1 · measuring, 24.6 s of data
4.000300 ± 0.000039 Hz

element  stiffness            damping             most of u²(c)
      1  24.011 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      2  24.012 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      3  24.013 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      4  24.014 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
± is the half width of the 95 % interval, if the rig is as its file says

settled    data count from 6.42 s to 31.00 s, first said at 7.10 s
reason     0.2 % of the transient is left, 0.5 % allowed
transient  decayed in 5.90 s; 5.70 s expected from the coefficients

channel   amplitude             phase to y0        mean          harmonic
y0        5.00000 ± 0.00020 mm       0          °  1.20000 mm  0.2 % (2f)
y1        5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
y2        5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
y3        5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
reaction  5.00000 ± 0.00020 mN  0.0000 ± 0.0032 °  1.20000 mN  0.2 % (2f)


space pause  n b page 1 of 2  q quit
)");
}

TEST(WatchPage, OneElementOnAWideTerminalLeavesTheKeysAtTheBottom) {
  const Page page = at(watched(chain(1)), {}, {40, 120});
  ASSERT_EQ(page.lines.size(), 40U);
  EXPECT_EQ(page.pages, 1U);
  EXPECT_EQ(
      text_of(page),
      R"(bench 2                                                                                             age 0.1 s · 14:03:22
dwell 1 · measuring, 24.6 s of data
4.000300 ± 0.000039 Hz

element  stiffness            damping             most of u²(c)     most of u²(r)
      1  24.011 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1  85 % delay of y0
± is the half width of the 95 % interval, if the rig is as its file says

settled    data count from 6.42 s to 31.00 s, first said at 7.10 s
reason     0.2 % of the transient is left, 0.5 % allowed
transient  decayed in 5.90 s; 5.70 s expected from the coefficients

channel   amplitude             phase to y0        mean          harmonic
y0        5.00000 ± 0.00020 mm       0          °  1.20000 mm  0.2 % (2f)
reaction  5.00000 ± 0.00020 mN  0.0000 ± 0.0032 °  1.20000 mN  0.2 % (2f)
























space pause  q quit
)");
}

TEST(WatchPage, ASmallTerminalTurnsPages) {
  const std::vector<Page> pages = all_pages(watched(chain(4)), {12, 40});
  EXPECT_EQ(text_of(pages[0]), R"(bench 2             age 0.1 s · 14:03:22
dwell 1 · measuring, 24.6 s of data
4.000300 ± 0.000039 Hz

element  stiffness
      1  24.011 ± 0.027 kN/m
      2  24.012 ± 0.027 kN/m
      3  24.013 ± 0.027 kN/m
      4  24.014 ± 0.027 kN/m


space pause  n b page 1 of 9  q quit
)");
}

TEST(WatchPage, ThirtyElementsGoOnOverleafBelowTheirTitles) {
  const std::vector<Page> pages = all_pages(watched(chain(30)), kUsual);
  EXPECT_EQ(text_of(pages[0]), R"(bench 2                                                     age 0.1 s · 14:03:22
dwell 1 · measuring, 24.6 s of data
4.000300 ± 0.000039 Hz

element  stiffness            damping             most of u²(c)
      1  24.011 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      2  24.012 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      3  24.013 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      4  24.014 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      5  24.015 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      6  24.016 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      7  24.017 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      8  24.018 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      9  24.019 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     10  24.020 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     11  24.021 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     12  24.022 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     13  24.023 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     14  24.024 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     15  24.025 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     16  24.026 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     17  24.027 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     18  24.028 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
space pause  n b page 1 of 6  q quit
)");
  EXPECT_EQ(text_of(pages[1]), R"(bench 2                                                     age 0.1 s · 14:03:22
dwell 1 · measuring, 24.6 s of data
4.000300 ± 0.000039 Hz

element  stiffness            damping             most of u²(c)
     19  24.029 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     20  24.030 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     21  24.031 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     22  24.032 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     23  24.033 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     24  24.034 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     25  24.035 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     26  24.036 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     27  24.037 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     28  24.038 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     29  24.039 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
     30  24.040 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
± is the half width of the 95 % interval, if the rig is as its file says

settled    data count from 6.42 s to 31.00 s, first said at 7.10 s
reason     0.2 % of the transient is left, 0.5 % allowed
transient  decayed in 5.90 s; 5.70 s expected from the coefficients

space pause  n b page 2 of 6  q quit
)");
}

// Whatever the size, every number and every word stands on some page, and no page is larger than the terminal.
TEST(WatchPage, NothingIsLostOnAnySize) {
  for (const int n : {1, 4, 30}) {
    DwellView view = chain(n);
    for (int i = 0; i < 40; ++i)
      view.dwell.warnings.push_back(
          {WarningKind::readings, "warning number" + std::to_string(i) + " is longer than a terminal of eighty " +
                                      "columns, and still it must not lose a word, down to its end" +
                                      std::to_string(i)});
    view.dwell.doubts = {{{1}, "the first doubt"}, {{}, "the second doubt"}};
    for (const Size size : {Size{24, 80}, Size{40, 120}, Size{12, 40}, Size{8, 50}}) {
      std::string all;
      for (const Page& page : all_pages(watched(view), size)) {
        ASSERT_LE(page.lines.size(), size.rows);
        for (const TextLine& line : page.lines) {
          ASSERT_LE(width(line.text), size.columns) << line.text;
          all += line.text + "\n";
        }
      }
      std::vector<std::string> expected{"first", "second", "0.05", "5.90 s;", "6.42 s", "4.000300 ± 0.000039 Hz"};
      for (int i = 0; i < 40; ++i) expected.push_back("end" + std::to_string(i) + "\n");
      for (int k = 1; k <= n; ++k) expected.push_back(std::to_string(k) + "  24.0" + std::to_string(10 + k));
      for (int i = 0; i < n; ++i) expected.push_back("\ny" + std::to_string(i) + " ");
      expected.erase(expected.begin() + 2);
      for (const std::string& text : expected)
        EXPECT_NE(all.find(text), std::string::npos) << text << " at " << size.rows << " x " << size.columns;
    }
  }
}

// They must not be missed where the coefficients alone fill the first page.
TEST(WatchPage, TheHeaderSaysHowManyWarningsThereAreAndWhere) {
  DwellView view = chain(30);
  view.dwell.warnings = {{WarningKind::readings, "channel y2 is stale: timeout"}, {WarningKind::hum, "hum"}};
  view.dwell.doubts = {{{2}, "y1 and y2 look swapped"}};
  const std::vector<Page> pages = all_pages(watched(view), kUsual);
  EXPECT_EQ(pages[0].lines[1].text, "dwell 1 · measuring, 24.6 s of data · 1 doubt, page 1 · 2 warnings, page 3");
  EXPECT_EQ(pages[0].lines[1].style, Style::alarm);
  EXPECT_EQ(pages[0].lines[4].text, "do not rely on element 2: y1 and y2 look swapped");
  EXPECT_NE(text_of(pages[2]).find("warning: channel y2 is stale: timeout\nwarning: hum\n"), std::string::npos);
}

// At an idle rig, where all is well, the header counted a warning.
TEST(WatchPage, ThatADwellHasNotSettledIsNoWarning) {
  Dwell idle;
  idle.state = State::idle;
  idle.settling_reason = "the table does not move";
  idle.warnings = {{WarningKind::not_settled, "not settled: the table does not move"}};
  const std::string text = text_of(at(watched(make_view(idle, test::sample_rig(), test::sample_run())), {}, kUsual));
  EXPECT_EQ(text.find("warning"), std::string::npos) << text;
}

// A device had been dead for 6 s, and the first line said "age 0.0 s" and no reason.
TEST(WatchPage, AFaultHasItsReasonInTheFirstLineAndTheAgeOfTheNumbers) {
  Dwell fault;
  fault.state = State::fault;
  fault.settling_reason = "the drive is not seen: y0 is timeout";
  WatchState state = watched(chain(3));
  const double end_s = chain(3).dwell.end_s;
  const auto start_ns = record::parse_utc(test::sample_run().start_utc);
  ASSERT_TRUE(start_ns);
  state.take_utc(*start_ns + static_cast<std::int64_t>(1e9 * (end_s + 6.0)), 106.0);
  state.take(make_view(fault, test::sample_rig(), test::sample_run()), 106.0);
  const Page page = at(state, {}, kUsual, 106.0);
  EXPECT_NE(page.lines[0].text.find("age 6.0 s"), std::string::npos) << page.lines[0].text;
  EXPECT_EQ(page.lines[1].text, "fault: the drive is not seen: y0 is timeout");
}

TEST(WatchPage, DoubtsLongerThanAScreenLeaveTheCoefficientsOnTheFirstPage) {
  DwellView view = chain(4);
  for (int i = 0; i < 50; ++i) view.dwell.doubts.push_back({{}, "doubt" + std::to_string(i)});
  const std::vector<Page> pages = all_pages(watched(view), kUsual);
  EXPECT_EQ(text_of(pages[0]), R"(bench 2                                                     age 0.1 s · 14:03:22
dwell 1 · measuring, 24.6 s of data · 50 doubts, page 1
4.000300 ± 0.000039 Hz

do not rely on any element: doubt0
do not rely on any element: doubt1
do not rely on any element: doubt2
do not rely on any element: doubt3
do not rely on any element: doubt4
do not rely on any element: doubt5
do not rely on any element: doubt6
do not rely on any element: doubt7
… continued below the coefficients

element  stiffness              damping               most of u²(c)
      1  24.011 ± 0.027 kN/m ?  60.20 ± 0.79 N·s/m ?  60 % scale of y1
      2  24.012 ± 0.027 kN/m ?  60.20 ± 0.79 N·s/m ?  60 % scale of y1
      3  24.013 ± 0.027 kN/m ?  60.20 ± 0.79 N·s/m ?  60 % scale of y1
      4  24.014 ± 0.027 kN/m ?  60.20 ± 0.79 N·s/m ?  60 % scale of y1
± is the half width of the 95 % interval, if the rig is as its file says; ?: do
  not rely on it, the reason stands with the dwell


space pause  n b page 1 of 5  q quit
)");
  std::string all;
  for (const Page& page : pages) all += text_of(page);
  for (int i = 0; i < 50; ++i) EXPECT_NE(all.find(": doubt" + std::to_string(i) + "\n"), std::string::npos) << i;
}

// Two doubts of five lines each, and a legend, leave the first page to the coefficients; the legend goes on overleaf.
TEST(WatchPage, ALegendThatDoesNotFitDoesNotTakeTheCoefficientsAlong) {
  DwellView view = chain(4);
  const std::string long_doubt = std::string(36, 'a') + " " + std::string(330, 'b');
  view.dwell.doubts = {{{}, long_doubt}, {{1}, long_doubt}};
  view.dwell.elements[1].identifiable = false;
  view.dwell.elements[1].reason = std::string(600, 'c');
  const std::vector<Page> pages = all_pages(watched(view), kUsual);
  const std::string first = text_of(pages[0]);
  for (int k = 1; k <= 4; ++k) EXPECT_NE(first.find("\n      " + std::to_string(k) + "  "), std::string::npos) << first;
  EXPECT_NE(first.find("element 2 is not identifiable"), std::string::npos) << first;
  EXPECT_NE(text_of(pages[1]).find("± is the half width"), std::string::npos) << text_of(pages[1]);
}

TEST(WatchPage, AQuestionTakesThePlaceOfTheKeys) {
  Controls controls;
  controls.may_rearm = true;
  EXPECT_EQ(at(watched(chain(1)), controls, {40, 120}).lines.back().text, "space pause  r rearm  q quit");
  controls.question = "rearm: end this dwell here and settle anew?";
  const Page page = at(watched(chain(1)), controls, {40, 120});
  EXPECT_EQ(page.lines.back().text, "rearm: end this dwell here and settle anew? y n");
  controls.question.clear();
  controls.keys = false;
  EXPECT_EQ(at(watched(chain(1)), controls, {40, 120}).lines.back().text, "Ctrl-C ends it");
}

TEST(WatchPage, AModelWithoutAVerdictHasItsReasonBesideIt) {
  DwellView view = chain(1);
  view.model = ModelVerdict{Verdict::not_verified, {}, 0.05, kNaN, kNaN};
  WatchState state = watched(view);
  EXPECT_EQ(at(state, {}, {40, 120}).lines[1].text, "dwell 1 · measuring, 24.6 s of data · model not verified yet");
  state.take(WhyUnverified{1, "the transient is too weak"});
  EXPECT_EQ(at(state, {}, {40, 120}).lines[1].text,
            "dwell 1 · measuring, 24.6 s of data · model not verified yet: the transient is too weak");
}

TEST(WatchPage, BeforeTheFirstWordItSaysThatItWaits) {
  WatchState state;
  state.name = "http://bench2:8380";
  const Page page = at(state, {}, kUsual);
  EXPECT_EQ(page.lines[0].text, "http://bench2:8380" + std::string(46, ' ') + "age — · 14:03:22");
  EXPECT_EQ(page.lines[1].text, "waiting for the service's first word");
}

TEST(WatchPage, AnAbsurdlySmallTerminalDoesNotHarm) {
  const WatchState state = watched(chain(4));
  for (std::size_t rows = 1; rows < 8; ++rows) {
    for (std::size_t columns = 1; columns < 30; columns += 7) {
      const Page page = at(state, {}, {rows, columns});
      EXPECT_LE(page.lines.size(), rows);
      for (const TextLine& line : page.lines) EXPECT_LE(width(line.text), columns);
    }
  }
}

TEST(WatchPage, NamesFromOutsideCannotSteerTheTerminal) {
  WatchState state = watched(chain(1));
  state.name = "bench\x1b[2J";
  state.trouble = "refused\x1b]0;x";
  EXPECT_EQ(text_of(at(state, {}, kUsual)).find('\x1b'), std::string::npos);
  EXPECT_EQ(last_words(state, nullptr, 100.1).find('\x1b'), std::string::npos);
}

// What comes of the transient stands on the first page, in looks of its own, and is old when all else is.
TEST(WatchPage, ShowsTheCoefficientsOfTheTransientAboveTheSettlingNotice) {
  const WatchState state = watched(test::settling_view());
  const Page page = at(state, {}, {24, 80});
  const auto title = std::find_if(page.lines.begin(), page.lines.end(),
                                  [](const TextLine& line) { return line.text.rfind("from the transient", 0) == 0; });
  ASSERT_NE(title, page.lines.end()) << text_of(page);
  EXPECT_EQ(title->text, "from the transient, 40.0 to 43.2 s, an estimate before the verdict:");
  EXPECT_EQ(title->style, Style::tentative);
  EXPECT_EQ((title + 2)->style, Style::tentative);
  EXPECT_LT(text_of(page).find("from the transient"), text_of(page).find("settled    no"));
  const Page old = at(state, {}, {24, 80}, 100.0 + 60.0);
  for (const TextLine& line : old.lines) EXPECT_NE(line.style, Style::tentative) << line.text;
}

TEST(WatchPage, SaysWhatTheUncertaintyOfTheLastDwellDoesNotCover) {
  Dwell idle, last = test::sample_dwell();
  idle.state = State::idle;
  last.state = State::complete;
  last.unstated = {"mass 1"};
  WatchState state = watched(make_view(idle, test::sample_rig(), test::sample_run()));
  state.take_last(make_view(last, test::sample_rig(), test::sample_run()));
  const std::string text = text_of(at(state, {}, {60, 120}));
  EXPECT_NE(text.find("not of now"), std::string::npos) << text;
  EXPECT_NE(text.find("what the rig file states; not stated: mass 1"), std::string::npos) << text;
}

TEST(WatchPage, TheLastWordsSayWhatTheUncertaintyDoesNotCover) {
  Dwell last = test::sample_dwell();
  last.unstated = {"mass 1"};
  const WatchState state = watched(make_view(last, test::sample_rig(), test::sample_run()));
  EXPECT_NE(last_words(state, nullptr, 100.1).find("not stated: mass 1"), std::string::npos);
}

TEST(WatchPage, CountsAContradictionAmongTheWarnings) {
  DwellView view = test::measured_view(3.0);
  auto beside = std::make_shared<MotionView>(*view.transient);
  beside->agreement->contradicts = true;
  view.transient = beside;
  EXPECT_NE(text_of(at(watched(view), {}, {40, 120})).find("2 warnings"), std::string::npos)
      << text_of(at(watched(view), {}, {40, 120}));
}

}  // namespace
}  // namespace dwell::ctl
