// Numbers for people: value ± U with its unit, U rounded to two significant digits and the value to match (JCGM 100,
// 7.2.6), an SI prefix where the unit takes one. A number that does not exist is shown as "—", never as zero.
//
// Text is UTF-8. Rounding is done on decimal digits, so it holds at decade borders (9.96 is shown as 10) and for every
// finite double.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/printable.hpp"

namespace dwell {

inline constexpr double kNormal95 = 1.959964;  // half width of the 95 % interval of a normal distribution, in u

inline constexpr const char* kNoNumber = "—";

inline constexpr int kMaxDigits = 15;  // significant decimal digits that a double carries

// The parts of "24.010 ± 0.027 kN/m", apart so that a column can be aligned.
struct NumberText {
  std::string value;
  std::string uncertainty;  // empty: nothing to show behind the value
  std::string unit;         // with its prefix
};

// unit: as in the JSON ("N*s/m"); "" for a pure number. U: the half width to show. U not finite or negative: shown as
// "—", the value with six digits. U = 0: the value with ten digits.
[[nodiscard]] NumberText number_text(double value, double U, std::string_view unit);
// A value that carries no uncertainty (a reading, a true value), with `digits` significant digits.
[[nodiscard]] NumberText number_text(double value, std::string_view unit, int digits);

[[nodiscard]] std::string join(const NumberText& number);
// The same for a column: values end, ± and units begin at the same place in every line.
[[nodiscard]] std::vector<std::string> join_aligned(const std::vector<NumberText>& numbers);

// "N*m*s/rad" as people write it: "N·m·s/rad"; "m/s2": "m/s²"; "um": "µm".
[[nodiscard]] std::string pretty_unit(std::string_view unit);

// A duration or an instant in seconds with `decimals` decimals, "—" if it is not known.
[[nodiscard]] std::string seconds_text(double seconds, int decimals);

// "0.3 s", "778 s", "21 min", "5 h", "3 d": how old something is, as people say it; "—" if that is not known.
[[nodiscard]] std::string age_text(double seconds);

// A text of an event with one of a kind said as people do: "timeout, 1 times" gives "timeout, once", "1 samples lost"
// gives "1 sample lost". Stored texts keep the plural: their counts are added up.
[[nodiscard]] std::string with_singular(std::string text);

// Columns that a terminal needs for a text: its code points.
[[nodiscard]] std::size_t width(std::string_view utf8) noexcept;
[[nodiscard]] std::string pad_left(std::string_view text, std::size_t columns);
[[nodiscard]] std::string pad_right(std::string_view text, std::size_t columns);

}  // namespace dwell
