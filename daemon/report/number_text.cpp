#include "daemon/report/number_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace dwell {
namespace {

// A number rounded to a quantum: digits · 10^quantum, without sign.
struct Decimal {
  std::string digits;  // without leading zeros; "0" is zero
  int quantum = 0;     // power of ten of the last digit

  [[nodiscard]] bool zero() const { return digits == "0"; }
  [[nodiscard]] int order() const { return quantum + static_cast<int>(digits.size()) - 1; }
};

// `count` significant digits of |v| > 0 (1 … 18), as printf rounds them: exactly, on the binary value.
Decimal significant(double v, int count) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.*e", count - 1, std::fabs(v));
  const std::string_view all(text.data());
  const std::size_t e = all.find('e');
  Decimal d;
  for (const char c : all.substr(0, e)) {
    if (c != '.') d.digits += c;
  }
  d.quantum = std::atoi(text.data() + e + 1) - (count - 1);
  return d;
}

Decimal round_to(double v, int quantum) {
  if (v == 0.0) return {"0", quantum};
  const int count = significant(v, 1 + kMaxDigits).order() - quantum + 1;
  if (count < 0) return {"0", quantum};
  if (count == 0) return {significant(v, 1 + kMaxDigits).digits[0] >= '5' ? "1" : "0", quantum};
  Decimal d = significant(v, std::min(count, kMaxDigits + 2));
  // Rounding up may have carried into one more digit.
  while (d.quantum > quantum) {
    d.digits += '0';
    --d.quantum;
  }
  return d;
}

// The digits with the decimal point where 10^power is the unit.
std::string place(const Decimal& d, int power) {
  const int decimals = power - d.quantum;
  std::string text = d.digits;
  if (decimals <= 0) {
    if (!d.zero()) text.append(static_cast<std::size_t>(-decimals), '0');
    return text;
  }
  const auto behind = static_cast<std::size_t>(decimals);
  if (text.size() <= behind) text.insert(0, behind + 1 - text.size(), '0');
  text.insert(text.size() - behind, 1, '.');
  return text;
}

std::string superscript(int number) {
  static constexpr std::array<const char*, 10> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = number < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(number))) text += digits[static_cast<std::size_t>(c - '0')];
  return text;
}

bool takes_prefix(std::string_view unit) {
  static constexpr std::array<std::string_view, 12> units{"m", "m/s", "m/s2", "rad",   "rad/s",   "rad/s2",
                                                          "N", "N*m", "N/m",  "N*s/m", "N*m/rad", "N*m*s/rad"};
  return std::find(units.begin(), units.end(), unit) != units.end();
}

// The power of ten to show a number of this order in, a multiple of three, and the unit that then belongs to it.
int choose_power(int order, std::string_view unit, std::string& shown_unit) {
  const int thousands = order >= 0 ? order / 3 : -((2 - order) / 3);
  const std::string base = pretty_unit(unit);
  if (takes_prefix(unit) && thousands >= -4 && thousands <= 4) {
    static constexpr std::array<const char*, 9> prefixes{"p", "n", "µ", "m", "", "k", "M", "G", "T"};
    const int place = thousands + 4;
    shown_unit = prefixes[static_cast<std::size_t>(place)] + base;
    return 3 * thousands;
  }
  if (order >= -4 && order <= 6) {
    shown_unit = base;
    return 0;
  }
  shown_unit = "×10" + superscript(3 * thousands) + (base.empty() ? "" : " " + base);
  return 3 * thousands;
}

}  // namespace

NumberText number_text(double value, double U, std::string_view unit) {
  if (!std::isfinite(value)) return {kNoNumber, "", ""};
  const bool rounded_by_U = std::isfinite(U) && U > 0.0;
  const int own_order = value == 0.0 ? -400 : significant(value, 1 + kMaxDigits).order();
  Decimal u;
  int quantum = 0;
  bool beyond_digits = false;
  if (rounded_by_U) {
    u = significant(U, 2);
    quantum = u.quantum;
    beyond_digits = own_order - quantum >= kMaxDigits;
    if (beyond_digits) quantum = own_order - kMaxDigits + 1;
  } else {
    quantum = value == 0.0 ? 0 : own_order - (U == 0.0 ? 9 : 5);
  }
  const Decimal v = round_to(value, quantum);
  int order = v.zero() ? 0 : v.order();
  if (rounded_by_U && (v.zero() || u.order() > order)) order = u.order();

  NumberText text;
  const int power = choose_power(order, unit, text.unit);
  text.value = place(v, power);
  if (value < 0.0 && !v.zero()) text.value.insert(0, 1, '-');
  if (!rounded_by_U) {
    text.uncertainty = U == 0.0 ? "0" : kNoNumber;
  } else if (beyond_digits) {
    text.uncertainty = u.digits.substr(0, 1) + "." + u.digits.substr(1) + "e" + std::to_string(u.order() - power);
  } else {
    text.uncertainty = place(u, power);
  }
  return text;
}

NumberText number_text(double value, std::string_view unit, int digits) {
  if (!std::isfinite(value)) return {kNoNumber, "", ""};
  const Decimal v = value == 0.0 ? Decimal{"0", 0} : significant(value, std::clamp(digits, 1, kMaxDigits));
  NumberText text;
  const int power = choose_power(v.zero() ? 0 : v.order(), unit, text.unit);
  text.value = place(v, power);
  if (value < 0.0) text.value.insert(0, 1, '-');
  return text;
}

std::string join(const NumberText& number) {
  std::string text = number.value;
  if (!number.uncertainty.empty()) text += " ± " + number.uncertainty;
  if (!number.unit.empty()) text += " " + number.unit;
  return text;
}

std::vector<std::string> join_aligned(const std::vector<NumberText>& numbers) {
  std::size_t value_width = 0;
  std::size_t uncertainty_width = 0;
  for (const NumberText& n : numbers) {
    value_width = std::max(value_width, width(n.value));
    uncertainty_width = std::max(uncertainty_width, width(n.uncertainty));
  }
  std::vector<std::string> lines;
  lines.reserve(numbers.size());
  for (const NumberText& n : numbers) {
    std::string line = pad_left(n.value, value_width);
    if (uncertainty_width > 0)
      line += (n.uncertainty.empty() ? "   " : " ± ") + pad_left(n.uncertainty, uncertainty_width);
    if (!n.unit.empty()) line += " " + n.unit;
    line.erase(line.find_last_not_of(' ') + 1);
    lines.push_back(std::move(line));
  }
  return lines;
}

std::string pretty_unit(std::string_view unit) {
  std::string text;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const char c = unit[i];
    if (c == '*') {
      text += "·";
    } else if (c == '2' && i > 0 && unit[i - 1] == 's') {
      text += "²";
    } else if (c == 'u' && i == 0 && unit.size() > 1 && unit[1] == 'm') {
      text += "µ";
    } else {
      text += c;
    }
  }
  return text;
}

std::string seconds_text(double seconds, int decimals) {
  if (!std::isfinite(seconds) || std::fabs(seconds) >= 1e12) return kNoNumber;
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "%.*f s", std::clamp(decimals, 0, 9), seconds);
  return text.data();
}

std::string age_text(double seconds) {
  if (!std::isfinite(seconds)) return kNoNumber;
  seconds = std::max(0.0, seconds);
  const auto whole = [](double value, const char* unit) {
    return std::to_string(static_cast<long long>(value)) + unit;
  };
  if (seconds < 9.95) return seconds_text(seconds, 1);
  if (seconds < 1000.0) return whole(seconds, " s");
  if (seconds < 7200.0) return whole(seconds / 60.0, " min");
  if (seconds < 172800.0) return whole(seconds / 3600.0, " h");
  return whole(seconds / 86400.0, " d");
}

std::string with_singular(std::string text) {
  static constexpr std::array<std::array<std::string_view, 2>, 3> kWords{
      {{"1 times", "once"}, {"1 samples", "1 sample"}, {"1 records", "1 record"}}};
  const auto in_number = [&text](std::size_t at) {
    return at > 0 && (std::isalnum(static_cast<unsigned char>(text[at - 1])) != 0 || text[at - 1] == '.');
  };
  for (const auto& [plural, singular] : kWords)
    for (std::size_t at = text.find(plural); at != std::string::npos; at = text.find(plural, at + singular.size()))
      if (!in_number(at)) text.replace(at, plural.size(), singular);
  return text;
}

std::size_t width(std::string_view utf8) noexcept {
  return static_cast<std::size_t>(
      std::count_if(utf8.begin(), utf8.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

std::string pad_left(std::string_view text, std::size_t columns) {
  const std::size_t own = width(text);
  return std::string(columns > own ? columns - own : 0, ' ').append(text);
}

std::string pad_right(std::string_view text, std::size_t columns) {
  const std::size_t own = width(text);
  return std::string(text).append(columns > own ? columns - own : 0, ' ');
}

}  // namespace dwell
