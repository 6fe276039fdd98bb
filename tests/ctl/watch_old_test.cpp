// Old numbers on the screen of watch: grey, marked with their age, and who is silent.
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "core/rig/limit.hpp"
#include "daemon/record/utc_text.hpp"
#include "tests/ctl/watched.hpp"

namespace dwell::ctl {
namespace {

using test::at, test::chain, test::kUsual, test::text_of, test::watched;

// 778 s after the service died, "measuring" stood above numbers at full strength.
TEST(WatchOld, NumbersOfAServiceThatHasGoneAreGreyAndMarkedWithTheirAge) {
  WatchState state = watched(chain(4));
  state.trouble = "trying again, http://bench2:8380: Connection refused";
  const Page page = at(state, {}, kUsual, 878.0);
  EXPECT_EQ(text_of(page), R"(bench 2                                                     age 778 s · 14:03:22
last seen: dwell 1 · measuring, 24.6 s of data
4.000300 ± 0.000039 Hz
NO CONNECTION: trying again, http://bench2:8380: Connection refused
OLD NUMBERS, from 778 s ago: the service has said nothing for 778 s

element    age  stiffness            damping             most of u²(c)
      1  778 s  24.011 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      2  778 s  24.012 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      3  778 s  24.013 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
      4  778 s  24.014 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1
± is the half width of the 95 % interval, if the rig is as its file says

settled    data count from 6.42 s to 31.00 s, first said at 7.10 s
reason     0.2 % of the transient is left, 0.5 % allowed
transient  decayed in 5.90 s; 5.70 s expected from the coefficients

channel     age  amplitude             phase to y0        mean          harmonic
y0        778 s  5.00000 ± 0.00020 mm       0          °  1.20000 mm  0.2 % (2f)
y1        778 s  5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
y2        778 s  5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
y3        778 s  5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
reaction  778 s  5.00000 ± 0.00020 mN  0.0000 ± 0.0032 °  1.20000 mN  0.2 % (2f)
space pause  n b page 1 of 2  q quit
)");
  for (const TextLine& line : page.lines) {
    const bool number = line.text.find("± 0") != std::string::npos || line.text.find("measuring") != std::string::npos;
    if (number) {
      EXPECT_EQ(line.style, Style::old) << line.text;
    }
  }
  EXPECT_EQ(page.lines[3].style, Style::alarm);
}

TEST(WatchOld, OnlyTheStaleChannelIsGrey) {
  WatchState state = watched(chain(4));
  ChannelState y1;
  y1.name = "y1";
  y1.status = "timeout: no answer within 0.1 s";
  y1.age_s = 12.0;
  state.take({y1}, 100.0);
  const Page page = at(state, {}, {40, 120});
  EXPECT_EQ(
      text_of(page),
      R"(bench 2                                                                                             age 0.1 s · 14:03:22
dwell 1 · measuring, 24.6 s of data
4.000300 ± 0.000039 Hz

element  stiffness            damping             most of u²(c)     most of u²(r)
      1  24.011 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1  85 % delay of y0
      2  24.012 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1  85 % delay of y0
      3  24.013 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1  85 % delay of y0
      4  24.014 ± 0.027 kN/m  60.20 ± 0.79 N·s/m  60 % scale of y1  85 % delay of y0
± is the half width of the 95 % interval, if the rig is as its file says

settled    data count from 6.42 s to 31.00 s, first said at 7.10 s
reason     0.2 % of the transient is left, 0.5 % allowed
transient  decayed in 5.90 s; 5.70 s expected from the coefficients

channel    age  amplitude             phase to y0        mean          harmonic
y0              5.00000 ± 0.00020 mm       0          °  1.20000 mm  0.2 % (2f)
y1        12 s  5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
y2              5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
y3              5.00000 ± 0.00020 mm  0.0000 ± 0.0032 °  1.20000 mm  0.2 % (2f)
reaction        5.00000 ± 0.00020 mN  0.0000 ± 0.0032 °  1.20000 mN  0.2 % (2f)
y1: now timeout: no answer within 0.1 s

















space pause  q quit
)");
  for (const TextLine& line : page.lines)
    EXPECT_EQ(line.style == Style::old, line.text.substr(0, 3) == "y1 ") << line.text;
}

TEST(WatchOld, PausedNumbersGrowOldAndTheScreenSaysThatItIsPaused) {
  Controls controls;
  controls.paused_s = 100.1;
  const Page soon = at(watched(chain(1)), controls, kUsual, 101.1);
  EXPECT_EQ(soon.lines[3].text, "PAUSED for 1.0 s; space goes on");
  EXPECT_EQ(soon.lines[6].style, Style::plain);
  const Page later = at(watched(chain(1)), controls, kUsual, 120.1);
  EXPECT_EQ(later.lines[4].text, "OLD NUMBERS, from 20 s ago: paused");
  EXPECT_EQ(later.lines[7].style, Style::old);
  EXPECT_EQ(later.lines.back().text, "space go on  q quit");
}

// The screen said that the service had said nothing, while it answered every second.
TEST(WatchOld, ASilentEstimationIsNotTakenForASilentService) {
  WatchState state = watched(chain(1));
  for (int i = 1; i <= 3; ++i) state.take(std::vector<ChannelState>(), 100.0 + i);
  EXPECT_EQ(at(state, {}, kUsual, 103.0).lines[3].text,
            "OLD NUMBERS, from 3.0 s ago: the service answers, but its estimation publishes");
  EXPECT_EQ(at(state, {}, kUsual, 103.0).lines[4].text, "  nothing new");
  EXPECT_EQ(at(state, {}, kUsual, 106.0).lines[3].text,
            "OLD NUMBERS, from 6.0 s ago: the service has said nothing for 3.0 s");
}

TEST(WatchOld, ADwellThatTheServiceCallsStaleIsOldAtOnceWithItsTrueAge) {
  DwellView view = chain(1);
  view.age = LiveAge{678.0, true};
  const Page page = at(watched(view), {}, kUsual, 101.0);
  EXPECT_EQ(page.lines[0].text.substr(page.lines[0].text.find("age")), "age 679 s · 14:03:22");
  EXPECT_EQ(page.lines[1].text.substr(0, 11), "last seen: ");
  EXPECT_EQ(page.lines[3].text, "OLD NUMBERS, from 679 s ago: the service answers, but its estimation publishes");
  for (const TextLine& line : page.lines)
    if (line.text.find("± 0") != std::string::npos) {
      EXPECT_EQ(line.style, Style::old) << line.text;
    }
}

TEST(WatchOld, TheTrendOfOldNumbersIsOld) {
  WatchState state;
  for (int i = 0; i <= 9; ++i) {
    DwellView view = chain(1);
    view.dwell.end_s += i;
    state.take(std::move(view), 100.0 + i);
  }
  const auto style_at = [&](double now_s) {
    for (const TextLine& line : at(state, {}, {40, 120}, now_s).lines)
      if (line.text.find("▅") != std::string::npos) return std::optional(line.style);
    return std::optional<Style>();
  };
  EXPECT_EQ(style_at(109.0), Style::plain);
  EXPECT_EQ(style_at(119.0), Style::old);
}

// "interlock closed" of before must not be taken for now; nor a list in which an alarm may be missing.
TEST(WatchOld, InterlockAndAlarmsThatAreNotAnsweredAnyLongerAreOfWhenTheyWereHeard) {
  WatchState state = watched(chain(1));
  state.take_gpio("interlock  closed\n", 100.0);
  AlarmsList list;
  list.unacknowledged = 1;
  state.take(list, 100.0);
  const auto shown = [&](double now_s) {
    DwellView view = chain(1);
    view.dwell.end_s += now_s;
    state.take(std::move(view), now_s);
    const Page page = at(state, {}, kUsual, now_s);
    return page.lines[3].text + "; " + page.lines[4].text;
  };
  EXPECT_EQ(shown(104.9), "interlock  closed; 1 alarm not acknowledged, page 1");
  EXPECT_EQ(shown(105.1), "when last heard: interlock  closed; when last heard: 1 alarm not acknowledged, page 1");
}

// As the service shows the last dwell of a run that was stopped while the drive was on.
DwellView stopped(EndedBy ended_by = EndedBy::end) {
  DwellView view = chain(1);
  view.dwell.state = State::complete;
  view.dwell.ended_by = ended_by;
  view.dwell.settling_reason = "the run was stopped: the next one begins with \"dwellctl start\"";
  return view;
}

TEST(WatchOld, ARunThatWasStoppedLeavesAResultWithTheTimeSinceItsEnd) {
  WatchState state = watched(stopped());
  state.take_utc(*record::parse_utc("2026-11-21T08:01:27Z"), 100.0);
  const Page page = at(state, {}, {40, 120});
  EXPECT_EQ(page.lines[0].text.substr(page.lines[0].text.find("age")), "age 56 s · 14:03:22");
  EXPECT_EQ(page.lines[1].text, "dwell 1 · complete, ended by: end, 24.6 s of data");
  EXPECT_EQ(page.lines[1].style, Style::past);
  EXPECT_EQ(page.lines[3].text,
            "NOT OF NOW, ended 56 s ago: the run was stopped: the next one begins with \"dwellctl start\"");
  EXPECT_EQ(text_of(page).find("OLD NUMBERS"), std::string::npos) << text_of(page);
  int numbers = 0;
  for (const TextLine& line : page.lines) {
    if (line.text.find("± 0") == std::string::npos) continue;
    ++numbers;
    EXPECT_EQ(line.style, Style::past) << line.text;
  }
  EXPECT_GE(numbers, 2);
  EXPECT_NE(text_of(page).find("      1  56 s  24.011 ± 0.027 kN/m"), std::string::npos) << text_of(page);
  EXPECT_NE(last_words(state, nullptr, 100.1).find("NOT OF NOW, ended 56 s ago: the run"), std::string::npos);
}

// When the drive had stopped, nobody saw any longer that a limit is violated, and that the model is adequate.
TEST(WatchOld, AResultKeepsTheVerdictsOnItsLimitsAndItsModel) {
  Rig rig = test::sample_rig();
  rig.limits = {{1, Bounds{20e3, 21e3}, std::nullopt}};
  Dwell dwell = test::sample_dwell();
  DwellView measured = make_view(dwell, rig, test::sample_run());
  measured.model = ModelVerdict{Verdict::adequate, true, 0.05, 0.012, 0.004};
  Dwell none;
  none.state = State::idle;
  DwellView idle = make_view(none, rig, test::sample_run(), judge_limits_now(rig, none));
  dwell.state = State::complete;
  DwellView ended = make_view(dwell, rig, test::sample_run(), judge_limits_now(rig, dwell));
  ASSERT_EQ(ended.limits.front().verdict, LimitVerdict::none);
  ended.model = measured.model;
  for (const DwellView& after : {idle, ended}) {
    WatchState state = test::watched(measured);
    state.take(after, 101.0);
    const Page page = test::at(state, {}, {60, 120}, 101.1);
    const std::string text = test::text_of(page);
    EXPECT_NE(text.find("model adequate"), std::string::npos) << text;
    const auto loud = std::find_if(page.lines.begin(), page.lines.end(),
                                   [](const TextLine& l) { return l.text.rfind("limits     violated", 0) == 0; });
    ASSERT_NE(loud, page.lines.end()) << text;
    EXPECT_EQ(loud->style, Style::alarm);
  }
}

TEST(WatchOld, ADwellThatHadEndedBeforeTheRunWasStoppedKeepsItsCause) {
  EXPECT_EQ(at(watched(stopped(EndedBy::data_lost)), {}, {40, 120}).lines[3].text,
            "NOT OF NOW, ended: data lost; the run was stopped: the next one begins with \"dwellctl start\"");
}

TEST(WatchOld, AResultOfAServiceThatFellSilentIsOldAsWell) {
  WatchState state = watched(stopped());
  state.take_utc(*record::parse_utc("2026-11-21T08:01:27Z"), 100.0);
  const Page page = at(state, {}, {40, 120}, 112.0);
  EXPECT_EQ(page.lines[1].text, "last seen: dwell 1 · complete, ended by: end, 24.6 s of data");
  EXPECT_EQ(page.lines[3].text, "OLD NUMBERS, from 12 s ago: the service has said nothing for 12 s");
  EXPECT_EQ(page.lines[4].text.substr(0, 28), "NOT OF NOW, ended 68 s ago: ");
}

TEST(WatchOld, WithoutAConnectionTheServiceIsTheOneThatIsSilent) {
  WatchState state = watched(chain(1));
  state.trouble = "the stream was lost";
  EXPECT_EQ(at(state, {}, kUsual, 100.5).lines[4].text,
            "OLD NUMBERS, from 0.5 s ago: the service has said nothing for 0.5 s");
}

}  // namespace
}  // namespace dwell::ctl
