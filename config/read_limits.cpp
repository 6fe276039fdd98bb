#include <algorithm>

#include "config/draft.hpp"

namespace dwell::config {
namespace {

// The element that the table limits: one of the chain, without limits so far.
void read_element(Section& section, Limit& limit, const Draft& draft) {
  const Rig& rig = draft.file.rig;
  const bool counted = draft.masses_known && draft.boundary_known;
  const std::int64_t last = counted ? rig.element_count() : static_cast<std::int64_t>(kMaxMasses) + 1;
  const std::string expected = "the number of an element, 1 to " + std::to_string(last) + (counted ? "" : " at most");
  std::int64_t element = 0;
  if (!section.integer("element", element, 1, last, expected.c_str(), Need::required)) return;
  limit.element = static_cast<int>(element);
  if (std::any_of(rig.limits.begin(), rig.limits.end(), [&](const Limit& l) { return l.element == limit.element; }))
    section.wrong("element", "element " + std::to_string(element) +
                                 " has limits already: expected one [[limit]] for each element, with \"stiffness\" "
                                 "and \"damping\" in it");
}

std::optional<Bounds> read_bounds(Section& section, const char* key, const char* expected) {
  Bounds bounds;
  if (!section.interval(key, bounds.low, bounds.high, expected, Section::Ends::one_may_be_open)) return std::nullopt;
  // A sound element lies above such an interval: most likely a sign is wrong.
  if (bounds.high <= 0.0)
    section.wrong(key, in_quotes(key) + " is [" + number_text(bounds.low) + ", " + number_text(bounds.high) +
                           "], nowhere above 0: expected " + expected + ", high above 0");
  return bounds;
}

Limit read_limit(Section& section, const Draft& draft) {
  Limit limit;
  read_element(section, limit, draft);
  limit.stiffness = read_bounds(section, "stiffness", "[low, high] in N/m (N*m/rad for rotation), low < high");
  limit.damping = read_bounds(section, "damping", "[low, high] in N*s/m (N*m*s/rad for rotation), low < high");
  if (section.peek("stiffness") == nullptr && section.peek("damping") == nullptr)
    section.missing("stiffness", "\"stiffness\" or \"damping\" = [low, high]");
  section.refuse_rest();
  return limit;
}

}  // namespace

void read_limits(Section& root, Draft& draft) {
  constexpr const char* kExpected = "tables [[limit]]";
  const toml::array* limits = root.array("limit", kExpected);
  if (limits == nullptr) return;
  for (const toml::node& node : *limits) {
    if (draft.mistakes.full()) return;
    if (const toml::table* table = node.as_table()) {
      Section section(*table, "[[limit]]", draft.mistakes);
      draft.file.rig.limits.push_back(read_limit(section, draft));
    } else {
      draft.mistakes.add(position(node), std::string("a limit is ") + type_name(node) + ": expected a table [[limit]]");
    }
  }
}

}  // namespace dwell::config
