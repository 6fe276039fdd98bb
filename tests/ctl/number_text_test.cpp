#include "daemon/report/number_text.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/result/dwell.hpp"
#include "daemon/report/table.hpp"

namespace dwell {
namespace {

std::string shown(double value, double U, const char* unit = "") { return join(number_text(value, U, unit)); }

TEST(NumberText, RoundsTheUncertaintyToTwoDigitsAndTheValueToMatch) {
  EXPECT_EQ(shown(24010.4, 27.4, "N/m"), "24.010 ± 0.027 kN/m");
  EXPECT_EQ(shown(60.2163, 0.7912, "N*s/m"), "60.22 ± 0.79 N·s/m");
  EXPECT_EQ(shown(0.005, 1.96e-7, "m"), "5.00000 ± 0.00020 mm");
  EXPECT_EQ(shown(4.0003, 3.9e-5, "Hz"), "4.000300 ± 0.000039 Hz");
}

TEST(NumberText, CarriesOverAtDecadeBorders) {
  EXPECT_EQ(shown(123.4, 9.96), "123 ± 10");
  EXPECT_EQ(shown(123.4, 9.94), "123.4 ± 9.9");
  EXPECT_EQ(shown(12.3456, 0.0996), "12.35 ± 0.10");
  EXPECT_EQ(shown(12346.0, 99.6, "N"), "12.35 ± 0.10 kN");
  EXPECT_EQ(shown(999.97, 1.2, "N"), "1.0000 ± 0.0012 kN");
  EXPECT_EQ(shown(460.0, 996.0, "N"), "0.5 ± 1.0 kN");
}

TEST(NumberText, AValueSmallerThanItsUncertaintyKeepsTheQuantum) {
  EXPECT_EQ(shown(0.04, 0.79, "N*s/m"), "40 ± 790 mN·s/m");
  EXPECT_EQ(shown(0.0049, 0.79), "0.00 ± 0.79");
  EXPECT_EQ(shown(-0.0049, 0.79), "0.00 ± 0.79") << "a rounded zero has no sign";
  EXPECT_EQ(shown(-0.0051, 0.79), "-0.01 ± 0.79");
  EXPECT_EQ(shown(4.96, 996.0), "0 ± 1000");
  EXPECT_EQ(shown(5.04, 996.0), "0 ± 1000");
}

TEST(NumberText, ShowsWhatDoesNotExistAsADash) {
  EXPECT_EQ(shown(kNaN, 0.1, "m"), "—");
  EXPECT_EQ(shown(std::numeric_limits<double>::infinity(), 0.1, "m"), "—");
  EXPECT_EQ(shown(1.25, kNaN, "N"), "1.25000 ± — N");
  EXPECT_EQ(shown(1.25, -1.0, "N"), "1.25000 ± — N");
}

TEST(NumberText, ZeroIsANumber) {
  EXPECT_EQ(shown(0.0, 0.0, "m"), "0 ± 0 m");
  EXPECT_EQ(shown(0.0, 0.012, "m"), "0 ± 12 mm");
  EXPECT_EQ(shown(1.5, 0.0), "1.500000000 ± 0");
  EXPECT_EQ(join(number_text(-0.0, "m", 5)), "0 m");
}

TEST(NumberText, HugeAndTinyExponentsStayReadable) {
  EXPECT_EQ(shown(1.5e20, 2.5e18, "N/m"), "150.0 ± 2.5 ×10¹⁸ N/m");
  EXPECT_EQ(shown(1.5e-20, 2.5e-22), "15.00 ± 0.25 ×10⁻²¹");
  EXPECT_EQ(shown(1.0, 1e-300), "1.00000000000000 ± 1.0e-300");
  EXPECT_EQ(shown(1e300, 1e-300, "N").substr(0, 10), "1.00000000");
  EXPECT_EQ(shown(5e-324, 5e-324).find("nan"), std::string::npos);
  EXPECT_EQ(shown(1e-300, 1.0), "0.0 ± 1.0");
}

RC_GTEST_PROP(NumberText, SaysTheValueToHalfItsLastDigitAndTheUncertaintyToTwoDigits, ()) {
  const double mantissa = *rc::gen::map(rc::gen::inRange(1, 1'000'000'000), [](int i) { return 1e-8 * i; });
  const int exponent = *rc::gen::inRange(-250, 250);
  const int below = *rc::gen::inRange(-12, 4);
  const double value = std::ldexp(mantissa, 3 * exponent) * (*rc::gen::arbitrary<bool>() ? 1.0 : -1.0);
  const double U = std::fabs(value) * std::pow(10.0, below) * *rc::gen::element(1.0, 9.96, 9.949, 3.3, 0.996);
  RC_PRE(std::isfinite(U) && U > 0.0);
  const NumberText text = number_text(value, U, "");
  double unit = 1.0;
  if (const auto at = text.unit.find("×10"); at != std::string::npos) {
    std::string digits;  // superscripts back to ASCII
    const std::vector<std::string> superscripts{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    for (std::size_t i = at + std::string("×10").size(); i < text.unit.size();) {
      if (text.unit.compare(i, 3, "⁻") == 0) digits += "-", i += 3;
      for (std::size_t d = 0; d < superscripts.size(); ++d) {
        if (text.unit.compare(i, superscripts[d].size(), superscripts[d]) == 0) {
          digits += std::to_string(d);
          i += superscripts[d].size();
          break;
        }
      }
    }
    unit = std::pow(10.0, std::stoi(digits));
  }
  const double value_back = std::strtod(text.value.c_str(), nullptr);
  const double U_back = std::strtod(text.uncertainty.c_str(), nullptr);
  RC_ASSERT(std::fabs(U_back * unit / U - 1.0) <= 0.0501);
  RC_ASSERT(std::fabs(value_back * unit - value) <= 0.0501 * U + 1e-14 * std::fabs(value));
  const auto decimals = [](const std::string& s) {
    return s.find('.') == std::string::npos ? 0 : s.size() - s.find('.');
  };
  RC_ASSERT(decimals(text.value) == decimals(text.uncertainty));
}

TEST(NumberText, AlignsAColumnWhateverItsUnits) {
  const std::vector<std::string> lines = join_aligned({number_text(24010.4, 27.4, "N/m"), number_text(5e-6, 1e-8, "m"),
                                                       number_text(kNaN, 1.0, "m"), number_text(3.0, "m", 3)});
  ASSERT_EQ(lines.size(), 4U);
  EXPECT_EQ(lines[0], "24.010 ± 0.027 kN/m");
  EXPECT_EQ(lines[1], " 5.000 ± 0.010 µm");
  EXPECT_EQ(lines[2], "     —");
  EXPECT_EQ(lines[3], "  3.00         m");
}

TEST(NumberText, WritesUnitsAsPeopleDo) {
  EXPECT_EQ(pretty_unit("N*m*s/rad"), "N·m·s/rad");
  EXPECT_EQ(pretty_unit("m/s2"), "m/s²");
  EXPECT_EQ(pretty_unit("um"), "µm");
  EXPECT_EQ(seconds_text(6.423, 2), "6.42 s");
  EXPECT_EQ(seconds_text(kNaN, 2), "—");
}

TEST(AgeText, IsAsPeopleSayIt) {
  EXPECT_EQ(age_text(0.04), "0.0 s");
  EXPECT_EQ(age_text(9.9), "9.9 s");
  EXPECT_EQ(age_text(9.96), "9 s");
  EXPECT_EQ(age_text(778.9), "778 s");
  EXPECT_EQ(age_text(1260.0), "21 min");
  EXPECT_EQ(age_text(18000.0), "5 h");
  EXPECT_EQ(age_text(3.5 * 86400.0), "3 d");
  EXPECT_EQ(age_text(kNaN), "—");
  EXPECT_EQ(age_text(-1.0), "0.0 s");
}

TEST(Table, LinesUpUnderUtf8AndLeavesNoTrailingBlanks) {
  Table table;
  table.add("name", {"µ", "long·name", "x"});
  table.add("value", {"1 ± 2", "—"}, Align::right);
  table.add("status", {"ok", "", "end"});
  EXPECT_EQ(table.text(),
            "name       value  status\n"
            "µ          1 ± 2  ok\n"
            "long·name      —\n"
            "x                 end\n");
  EXPECT_EQ(Table{}.text(), "");
}

// With U+202E "gpj.exe" is read as "exe.jpg". U+009B begins a command as ESC [ does.
TEST(Printable, LeavesNoControlOfTheTerminalAndNoneOfTheWritingDirection) {
  const char* const controls[] = {"\u0001", "\u001B", "\u007F", "\u0080", "\u009B", "\u009F",
                                  "\u061C", "\u200E", "\u200F", "\u202A", "\u202B", "\u202C",
                                  "\u202D", "\u202E", "\u2066", "\u2067", "\u2068", "\u2069"};
  for (const char* const control : controls) EXPECT_EQ(printable(std::string("a") + control + "b"), "a?b") << control;
}

TEST(Printable, LeavesTextInAnyLanguageAndBytesThatAreNoUtf8AsTheyAre) {
  const std::string beside =
      "\u00A0\u00B5 · ± \u061B\u061D \u200D\u2010 \u2027\u202F \u2065\u206A שלום 日本 \U0001F600";
  EXPECT_EQ(printable(beside), beside);
  for (const std::string broken : {"\xC2", "\xC2z", "\xE2\x80", "\xE2\x80z", "\x9B", "\xFF"})
    EXPECT_EQ(printable(broken), broken);
}

TEST(Table, DoesNotLetANameCommandTheTerminal) {
  Table table;
  table.add("n", {"a\x1b[2Jb\n\x7f\xc2\x9b"
                  "c"});
  EXPECT_EQ(table.text(), "n\na?[2Jb???c\n");
}

TEST(NumberText, SaysOneOfAKindInTheSingular) {
  EXPECT_EQ(with_singular("device amplifier: missed deadline, 1 times"), "device amplifier: missed deadline, once");
  EXPECT_EQ(with_singular("channel y0: 1 samples lost"), "channel y0: 1 sample lost");
  EXPECT_EQ(with_singular("1 records, 1 samples"), "1 record, 1 sample");
  for (const char* plural : {"11 times", "0.1 times", "x1 samples", "21 samples lost", "1 time"})
    EXPECT_EQ(with_singular(plural), plural);
}

}  // namespace
}  // namespace dwell
