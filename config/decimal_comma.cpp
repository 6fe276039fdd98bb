#include "config/decimal_comma.hpp"

#include <algorithm>
#include <cstdint>

namespace dwell::config {
namespace {

bool digit(char c) { return c >= '0' && c <= '9'; }

// 0,01 as an element: TOML knows no number that begins with 0 and goes on.
std::optional<std::string> in_array(std::string_view text) {
  for (std::size_t comma = text.find(','); comma != std::string_view::npos; comma = text.find(',', comma + 1)) {
    std::size_t begin = comma, end = comma + 1;
    while (begin > 0 && digit(text[begin - 1])) --begin;
    while (end < text.size() && digit(text[end])) ++end;
    if (begin == comma || end < comma + 3 || text[comma + 1] != '0') continue;
    if (begin > 0 && text[begin - 1] == '-') --begin;
    return std::string(text.substr(begin, comma - begin)) + "." + std::string(text.substr(comma + 1, end - comma - 1));
  }
  return std::nullopt;
}

}  // namespace

std::string decimal_comma_hint(const toml::array& numbers) {
  for (std::size_t i = 0; i + 1 < numbers.size(); ++i) {
    const auto whole = numbers[i].value_exact<std::int64_t>(), fraction = numbers[i + 1].value_exact<std::int64_t>();
    if (!whole || !fraction || *fraction < 0) continue;
    const std::string first = std::to_string(*whole);
    const auto a = numbers[i].source().begin, b = numbers[i + 1].source().begin;
    if (a.line == b.line && b.column == a.column + first.size() + 1)
      return "; expected a decimal point: " + first + "." + std::to_string(*fraction);
  }
  return "";
}

std::optional<std::string> decimal_comma(std::string_view text, int line) {
  for (; line > 1; --line) text.remove_prefix(std::min(text.find('\n'), text.size() - 1) + 1);
  text = text.substr(0, text.find_first_of("\r\n#"));
  const std::size_t equals = text.find('=');
  if (equals == std::string_view::npos) return std::nullopt;
  text.remove_prefix(equals + 1);
  const auto trim = [&text] { text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size())); };
  const auto digits = [&text] {
    const std::size_t count = std::min(text.find_first_not_of("0123456789"), text.size());
    const std::string_view found = text.substr(0, count);
    text.remove_prefix(count);
    return std::string(found);
  };
  trim();
  if (!text.empty() && text.front() == '[') return in_array(text);
  std::string number;
  if (!text.empty() && (text.front() == '-' || text.front() == '+')) {
    number = text.front();
    text.remove_prefix(1);
  }
  const std::string whole = digits();
  if (whole.empty() || text.empty() || text.front() != ',') return std::nullopt;
  text.remove_prefix(1);
  const std::string fraction = digits();
  trim();
  if (fraction.empty() || !text.empty()) return std::nullopt;
  return number + whole + "." + fraction;
}

}  // namespace dwell::config
