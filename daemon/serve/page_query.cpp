#include "daemon/serve/page_query.hpp"

#include <charconv>
#include <vector>

#include "daemon/serve/next_part.hpp"
#include "daemon/serve/query.hpp"

namespace dwell {

std::optional<int> integer_of(std::string_view text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

tl::expected<Page, std::string> page_of(std::string_view query, std::size_t most, const PageKeys& keys) {
  Page page;
  page.count = most;
  const std::string index(keys.index);
  std::vector<QueryKey> understood;
  understood.push_back({"from", "from=" + index + " (0 or more)" + (keys.file ? " or from=" + index + ":FILE" : ""),
                        [&](std::string_view value) {
                          const std::string_view number = keys.file ? next_part(value, ':') : value;
                          page.from = integer_of(number);
                          if (keys.file) page.from_file = percent_decoded(value);
                          return page.from && *page.from >= 0;
                        }});
  understood.push_back({"count", "count=1 to " + std::to_string(most), [&](std::string_view value) {
                          const auto number = integer_of(value);
                          if (!number || *number < 1 || static_cast<std::size_t>(*number) > most) return false;
                          page.count = static_cast<std::size_t>(*number);
                          return true;
                        }});
  if (keys.brief)
    understood.push_back({"brief", "brief=1", [&](std::string_view value) { return page.brief = value == "1"; }});
  if (auto fault = query_fault(query, understood)) return tl::unexpected(std::move(*fault));
  return page;
}

}  // namespace dwell
