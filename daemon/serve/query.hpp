// The query of a request, "from=3&count=5". Every path says which keys it understands; another one is refused, so that
// a slip of the pen never looks like an answer to it. Pure.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dwell {

struct QueryKey {
  std::string_view name;
  std::string expected;  // as people write it: "count=1 to 100"
  // Takes what stands behind the "="; empty where there is nothing. false: that is not understood.
  std::function<bool(std::string_view value)> take;
};

// Hands each value of the query to its key. nullopt: all were taken. Else, for the asker, what was found and what was
// expected: a key that is not known or given twice, or a value that its key does not take. No keys: the path takes no
// query. The time it takes grows with the length of the query.
[[nodiscard]] std::optional<std::string> query_fault(std::string_view query, const std::vector<QueryKey>& keys);

// %20 and the like as the bytes that they stand for.
[[nodiscard]] std::string percent_decoded(std::string_view text);
// The text with everything but letters, digits and "-._~" as such codes: it can stand in a query as a value.
[[nodiscard]] std::string percent_encoded(std::string_view text);

}  // namespace dwell
