#include "daemon/report/dwell_text.hpp"

#include <gtest/gtest.h>

#include "daemon/report/number_text.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell {
namespace {

DwellView sample_view() { return make_view(test::sample_dwell(), test::sample_rig(), test::sample_run()); }

TEST(DwellText, IsWhatAnOperatorReads) {
  EXPECT_EQ(dwell_text(sample_view()), R"(dwell 1 · measuring, 24.6 s of data

element  stiffness               damping                   most of u²(c)     most of u²(r)
      1   24.010 ±   0.027 kN/m  60.20 ± 0.79 N·s/m        60 % scale of y1  85 % delay of y0
      2        —                     —                     —                 —
      3  1.23457 ± 0.00020 MN/m    210 ±  790 mN·s/m n.s.  60 % scale of y1  85 % delay of y0
element 2 is not identifiable: the deformation is less than three times its uncertainty
± is the half width of the 95 % interval, if the rig is as its file says; n.s.: not significant, smaller than its standard uncertainty

warning: channel y2 is stale: timeout

settled    data count from 6.42 s to 31.00 s, first said at 7.10 s
reason     0.2 % of the transient is left, 0.5 % allowed
transient  decayed in 5.90 s; 5.70 s expected from the coefficients
frequency  4.000300 ± 0.000039 Hz

channel   amplitude               phase to y0        mean             harmonic
y0        5.00000 ± 0.00020 mm          0         °  1.20000 mm     0.2 % (2f)
a1         4.2000 ±  0.0020 m/s²  173.789 ± 0.027 °      1.2 mm/s²  0.2 % (2f)
y2              —                       —                  —                 —
reaction   86.300 ±   0.098 N     -20.054 ± 0.067 °        1 mN     0.2 % (2f)
y2: stale: timeout
)");
}

// Whoever stops reading after the first lines must have seen that these numbers are wrong.
TEST(DwellText, DoubtsComeFirstAndMarkTheCoefficientsTheyConcern) {
  Dwell dwell = test::sample_dwell();
  dwell.doubts = {{{1}, "the stiffness of element 1 is negative"}};
  const Rig rig = test::sample_rig();
  const std::string text = dwell_text(make_view(dwell, rig, {}));
  EXPECT_EQ(text.substr(0, text.find("element 2 is not")), R"(dwell 1 · measuring, 24.6 s of data

do not rely on element 1: the stiffness of element 1 is negative

element  stiffness                 damping                   most of u²(c)     most of u²(r)
      1   24.010 ±   0.027 kN/m ?  60.20 ± 0.79 N·s/m ?      60 % scale of y1  85 % delay of y0
      2        —                       —                     —                 —
      3  1.23457 ± 0.00020 MN/m      210 ±  790 mN·s/m n.s.  60 % scale of y1  85 % delay of y0
)");
  EXPECT_NE(text.find("?: do not rely on it, the reason stands with the dwell"), std::string::npos);
  const auto sections = dwell_sections(make_view(dwell, rig, {}));
  EXPECT_EQ(sections.at(0).body.at(0).style, Style::alarm);
  EXPECT_EQ(sections.at(1).body.at(0).style, Style::doubted);
  EXPECT_EQ(sections.at(1).body.at(2).style, Style::plain);

  dwell.doubts = {{{1, 3}, "y1 and y2 look swapped"}, {{}, "the model contradicts the data"}};
  const std::string all = dwell_text(make_view(dwell, rig, {}));
  EXPECT_NE(all.find("\ndo not rely on elements 1, 3: y1 and y2 look swapped\n"), std::string::npos) << all;
  EXPECT_NE(all.find("\ndo not rely on any element: the model contradicts the data\n"), std::string::npos) << all;
  EXPECT_NE(all.find("210 ±  790 mN·s/m n.s. ?"), std::string::npos) << all;
}

TEST(DwellText, WhereverAnIntervalStandsItSaysWhichUncertaintiesItLeavesOut) {
  Dwell dwell = test::sample_dwell();
  dwell.unstated = {"masses", "scale of y1"};
  EXPECT_NE(dwell_text(make_view(dwell, test::sample_rig(), {}))
                .find("\n± covers only noise, clock and what the rig file states; not stated: masses, scale of y1\n"),
            std::string::npos);
}

TEST(DwellText, ShowsTheTruthBesideTheMeasuredWithTheDeviation) {
  const Truth truth{{24000.0, 5000.0, 1234500.0}, {60.0, 12.0, 0.2}};
  const std::string text = dwell_text(sample_view(), &truth);
  EXPECT_EQ(text.substr(text.find("element "), text.find("element 2 is not") - text.find("element ")),
            R"(element  stiffness               true          off by  damping                   true            off by
      1   24.010 ±   0.027 kN/m  24.0000 kN/m  +0.7 u  60.20 ± 0.79 N·s/m        60.0000 N·s/m   +0.5 u
      2        —                 5.00000 kN/m       —      —                     12.0000 N·s/m        —
      3  1.23457 ± 0.00020 MN/m  1.23450 MN/m  +0.7 u    210 ±  790 mN·s/m n.s.  200.000 mN·s/m  +0.0 u
)");
}

TEST(DwellText, BeforeSettlingItSaysWhatIsAwaited) {
  EXPECT_EQ(dwell_text(make_view(test::settling_dwell(), test::sample_rig(), {})),
            R"(dwell 2 · settling, about 3.2 s left

settled    no
reason     2.1 % of the transient of reaction is left, 0.5 % allowed
frequency  4.000 Hz so far

channel   amplitude  phase
y0        —          —
a1        —          —
y2        —          —
reaction  —          —
y0: too few samples
a1: too few samples
y2: too few samples
reaction: too few samples
)");
}

// "4.689 ± 0.030 mm" stood there of a table that moved by 5 mm: a ± for noise, of a fit that took the transient for
// motion.
TEST(DwellText, BeforeSettlingNoIntervalIsShown) {
  Dwell dwell = test::settling_dwell();
  dwell.phasors = test::sample_dwell().phasors;
  dwell.frequency_hz = {3.5, 0.008};
  const std::string text = dwell_text(make_view(dwell, test::sample_rig(), {}));
  EXPECT_EQ(text.substr(text.find("frequency")), R"(frequency  3.500 Hz so far

channel   amplitude  phase to y0
y0        5.00 mm        0 °
a1        4.20 m/s²    174 °
y2           —           —
reaction  86.3 N     -20.1 °
not settled: part of the transient is in these numbers, so they have no ±
y2: stale: timeout
)");
}

TEST(DwellText, IdleIsOneLine) { EXPECT_EQ(dwell_text(make_view(Dwell{}, test::sample_rig(), {})), "idle\n"); }

// Eighty columns take nothing away: what finds no room beside the coefficients stands at the end.
TEST(DwellText, ANarrowTerminalLosesNothing) {
  for (const std::size_t columns : {80U, 60U, 40U}) {
    TextOptions options;
    options.columns = columns;
    std::string text = plain_text(dwell_sections(sample_view(), options));
    std::size_t begin = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos; begin = end + 1, end = text.find('\n', begin))
      EXPECT_LE(width(text.substr(begin, end - begin)), columns) << text.substr(begin, end - begin);
    for (const char* number : {"24.010 ±   0.027 kN/m", "60.20 ± 0.79 N·s/m", "85 % delay of y0", "60 % scale of y1",
                               "-20.054 ± 0.067 °", "1.20000 mm", "0.2 % (2f)", "y2: stale: timeout"})
      EXPECT_NE(text.find(number), std::string::npos) << columns << number;
  }
}

TEST(DwellText, OldNumbersAreMarkedWithTheirAge) {
  TextOptions options;
  options.age = "778 s";
  options.columns = 80;
  const auto sections = dwell_sections(sample_view(), options);
  EXPECT_EQ(sections.at(0).head.at(0).text, "element    age  stiffness               damping");
  EXPECT_EQ(sections.at(0).body.at(0).text, "      1  778 s   24.010 ±   0.027 kN/m  60.20 ± 0.79 N·s/m");
  EXPECT_EQ(sections.at(0).body.at(0).style, Style::old);

  options.age.clear();
  options.channels = {{}, {"12 s", "timeout: no answer"}, {}, {}};
  const auto one = dwell_sections(sample_view(), options);
  EXPECT_EQ(one.at(0).body.at(0).style, Style::plain);
  const Section& channels = one.at(3);
  EXPECT_EQ(channels.body.at(0).text, "y0              5.00000 ± 0.00020 mm          0         °  1.20000 mm");
  EXPECT_EQ(channels.body.at(1).text, "a1        12 s   4.2000 ±  0.0020 m/s²  173.789 ± 0.027 °      1.2 mm/s²");
  EXPECT_EQ(channels.body.at(1).style, Style::old);
  EXPECT_EQ(channels.body.at(0).style, Style::plain);
  EXPECT_EQ(channels.body.at(4).text, "a1: now timeout: no answer");
}

TEST(DwellText, AStaleChannelSaysWhyInItsOwnWords) {
  TextOptions options;
  options.channels = {{}, {}, {"12 s", "disconnected: 192.0.2.10:502: Connection reset by peer"}, {}};
  const std::string text = plain_text(dwell_sections(sample_view(), options));
  EXPECT_NE(text.find("\ny2: now disconnected: 192.0.2.10:502: Connection reset by peer\n"), std::string::npos) << text;
}

TEST(Wrapped, BreaksAtBlanksAndLosesNothing) {
  using Lines = std::vector<std::string>;
  EXPECT_EQ(wrapped("a ± of two words", 8, 2), (Lines{"a ± of", "two", "words"})) << "too narrow to indent";
  EXPECT_EQ(wrapped("a ± of two words", 10, 2), (Lines{"a ± of two", "  words"}));
  EXPECT_EQ(wrapped("aaaaaaaaaabbbbbbbbbb", 10, 2), (Lines{"aaaaaaaaaa", "  bbbbbbbb", "  bb"}));
  EXPECT_EQ(wrapped("", 10, 2), (Lines{""}));
  EXPECT_EQ(wrapped("short", kUnlimited, 2), (Lines{"short"}));
}

// At a cost that grows with the square of the length this takes a quarter of an hour.
TEST(Wrapped, TakesTheLargestEventOfARunFile) {
  const std::string text(8 << 20, 'a');
  const auto lines = wrapped(text, 80, 10);
  ASSERT_EQ(lines.size(), 1 + (text.size() - 80 + 69) / 70);
  EXPECT_EQ(lines[0], text.substr(0, 80));
  EXPECT_EQ(lines[1], std::string(10, ' ') + text.substr(0, 70));
}

// A drive beyond the search range settled for ever, and nobody was told why; the time left jumped to "165.3 s".
TEST(DwellText, ATimeLeftThatIsNotKnownHasItsReasonAndALongOneNoTenths) {
  Dwell dwell = test::settling_dwell();
  dwell.settles_in_s = 165.3;
  const auto line = [&] { return headline(make_view(dwell, test::sample_rig(), test::sample_run())); };
  EXPECT_EQ(line(), "dwell 2 · settling, about 165 s left");
  dwell.settles_in_s = kNaN;
  dwell.settling_reason = "the drive is at 5.5 Hz, beyond the search range";
  EXPECT_EQ(line(), "dwell 2 · settling, time left not known: the drive is at 5.5 Hz, beyond the search range");
}

}  // namespace
}  // namespace dwell
