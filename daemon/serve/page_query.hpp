// The query of an answer that comes in portions: from=INDEX, count=N, brief=1.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

namespace dwell {

struct Page {
  std::optional<int> from;  // index of the first; none: the newest
  std::string from_file;    // with `from`: the first file of that number that counts; empty: all of them do
  std::size_t count = 0;    // at most
  bool brief = false;       // brief=1: in short
};

// What a path understands beside count=N.
struct PageKeys {
  std::string_view index = "INDEX";  // the word for the number behind `from`
  bool brief = false;                // brief=1
  bool file = false;                 // from=INDEX:FILE
};

// Without `count`: `most`. Fails, with what was found and what was expected, where a key is not known or given twice,
// or its number is out of range.
[[nodiscard]] tl::expected<Page, std::string> page_of(std::string_view query, std::size_t most,
                                                      const PageKeys& keys = {});

// A decimal number and nothing else.
[[nodiscard]] std::optional<int> integer_of(std::string_view text);

}  // namespace dwell
