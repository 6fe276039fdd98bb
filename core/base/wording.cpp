#include "core/base/wording.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace dwell {
namespace {

std::string printed(const char* format, int precision, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, precision, value);
  return text;
}

bool fits_without_exponent(double value) {
  const double size = std::abs(value);
  return size == 0 || (size >= 1e-3 && size < 1e6);
}

}  // namespace

std::string brief(double value, int digits) {
  if (!std::isfinite(value)) return "—";
  if (!fits_without_exponent(value)) return printed("%.*e", digits - 1, value);
  const int before = value == 0 ? 0 : static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1;
  if (before < digits) return printed("%.*g", digits, value);
  const double unit = std::pow(10.0, before - digits);
  return printed("%.*f", 0, std::round(value / unit) * unit);
}

std::string percent(double part) { return brief(100 * part, 2) + " %"; }

std::string plus_minus(double value, double U, const std::string& unit) {
  if (!std::isfinite(U) || !(U > 0)) return brief(value, 6) + " ± — " + unit;
  const int last = static_cast<int>(std::floor(std::log10(U))) - 1;  // decade of the last digit shown
  if (fits_without_exponent(std::max(std::abs(value), U))) {
    const double step = std::pow(10.0, last);
    const int decimals = std::max(0, -last);
    return printed("%.*f", decimals, std::round(value / step) * step) + " ± " +
           printed("%.*f", decimals, std::round(U / step) * step) + " " + unit;
  }
  const double larger = std::max(std::abs(value), U);
  const int digits = std::clamp(static_cast<int>(std::floor(std::log10(larger))) - last, 0, 15);
  return printed("%.*e", digits, value) + " ± " + printed("%.*e", 1, U) + " " + unit;
}

std::string unit_text(const std::string& unit) {
  std::string text;
  for (const char c : unit) c == '*' ? text.append("·") : text.append(1, c);
  return text;
}

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text.append(i == 0 ? "" : i + 1 == names.size() ? " and " : ", ").append(names[i]);
  return text;
}

std::string elements_text(const std::vector<int>& ks) {
  if (ks.empty()) return "no element";
  std::vector<std::string> names;
  names.reserve(ks.size());
  for (const int k : ks) names.push_back(std::to_string(k));
  return (ks.size() == 1 ? "element " : "elements ") + listed(names);
}

}  // namespace dwell
