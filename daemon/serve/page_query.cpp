#include "daemon/serve/page_query.hpp"

#include <charconv>

#include "daemon/serve/next_part.hpp"

namespace dwell {

std::optional<int> integer_of(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

tl::expected<Page, std::string> page_of(std::string_view query, std::size_t most, std::string_view index,
                                        bool may_be_brief) {
  Page page{std::nullopt, most, false};
  bool counted = false;
  while (!query.empty()) {
    const std::string_view term = next_part(query, '&');
    std::string_view value = term;
    const std::string_view key = next_part(value, '=');
    const auto number = integer_of(value);
    const bool again = (key == "from" && page.from) || (key == "count" && counted) || (key == "brief" && page.brief);
    if (key == "from" && !again && number && *number >= 0) {
      page.from = number;
    } else if (key == "count" && !again && number && *number >= 1 && static_cast<std::size_t>(*number) <= most) {
      page.count = static_cast<std::size_t>(*number);
      counted = true;
    } else if (key == "brief" && !again && may_be_brief && number == 1) {
      page.brief = true;
    } else {
      return tl::unexpected("\"" + std::string(term) +
                            "\" is not understood: " + (again ? std::string(key) + " is given twice; " : "") +
                            "expected from=" + std::string(index) + " (0 or more), count=1 to " + std::to_string(most) +
                            (may_be_brief ? ", brief=1" : "") + ", or several joined by &");
    }
  }
  return page;
}

}  // namespace dwell
