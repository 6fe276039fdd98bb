#include "daemon/serve/page_query.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "daemon/serve/next_part.hpp"

namespace dwell {

std::optional<int> integer_of(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<Page> page_of(std::string_view query, std::size_t most, bool may_be_brief) {
  Page page{std::nullopt, most, false};
  bool counted = false;
  while (!query.empty()) {
    std::string_view term = next_part(query, '&');
    const std::string_view key = next_part(term, '=');
    const auto value = integer_of(term);
    if (!value) return std::nullopt;
    if (key == "from" && !page.from) {
      page.from = *value;
    } else if (key == "count" && !std::exchange(counted, true) && *value >= 1) {
      page.count = std::min(static_cast<std::size_t>(*value), most);
    } else if (key == "brief" && may_be_brief && !page.brief && *value == 1) {
      page.brief = true;
    } else {
      return std::nullopt;
    }
  }
  return page;
}

}  // namespace dwell
