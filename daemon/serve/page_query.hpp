// The query of an answer that comes in portions: from=INDEX, count=N, brief=1.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>

namespace dwell {

struct Page {
  std::optional<int> from;  // index of the first; none: the newest
  std::size_t count = 0;    // at most
  bool brief = false;       // brief=1: in short
};

// nullopt: the query is not understood. Without `count`, or if it is above `most`: `most`. may_be_brief: `brief` is
// understood.
[[nodiscard]] std::optional<Page> page_of(std::string_view query, std::size_t most, bool may_be_brief = false);

// A decimal number and nothing else.
[[nodiscard]] std::optional<int> integer_of(std::string_view text);

}  // namespace dwell
