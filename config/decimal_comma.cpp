#include "config/decimal_comma.hpp"

#include <algorithm>

namespace dwell::config {

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
