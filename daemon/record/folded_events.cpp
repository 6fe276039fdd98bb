#include "daemon/record/folded_events.hpp"

#include <charconv>
#include <map>
#include <optional>
#include <string_view>
#include <tuple>
#include <utility>

namespace dwell::record {
namespace {

// A text around the number that it counts: "device amplifier: timeout, " 3 " times".
struct Counted {
  std::string front, back;
  std::uint64_t count = 0;
};

std::optional<Counted> counted(const std::string& text, std::string_view unit) {
  const std::size_t end = text.rfind(unit);
  if (end == std::string::npos) return std::nullopt;
  std::size_t begin = end;
  while (begin > 0 && text[begin - 1] >= '0' && text[begin - 1] <= '9') --begin;
  Counted parts{text.substr(0, begin), text.substr(end), 0};
  const auto [stop, code] = std::from_chars(text.data() + begin, text.data() + end, parts.count);
  if (code != std::errc() || stop == text.data() + begin) return std::nullopt;
  return parts;
}

Counted parts_of(const std::string& text) {
  for (const std::string_view unit : {" times", " samples"})
    if (auto parts = counted(text, unit)) return std::move(*parts);
  return {text, {}, 0};
}

bool folds(const StoredEvent& event) { return event.what == "fault" || event.what == "loss"; }

}  // namespace

std::vector<FoldedEvent> folded(const std::vector<StoredEvent>& events) {
  std::vector<FoldedEvent> all;
  std::map<std::tuple<std::string, std::string, std::string>, std::pair<std::size_t, std::uint64_t>> seen;
  for (const StoredEvent& event : events) {
    Counted parts = folds(event) ? parts_of(event.text) : Counted();
    if (folds(event)) {
      const auto [found, fresh] =
          seen.try_emplace({event.what, parts.front, parts.back}, std::pair(all.size(), std::uint64_t{0}));
      auto& [at, sum] = found->second;
      sum += parts.count;
      if (!fresh) {
        ++all[at].entries;
        all[at].last_utc = event.utc;
        all[at].event.text = parts.count > 0 ? parts.front + std::to_string(sum) + parts.back
                                             : parts.front + ", " + std::to_string(all[at].entries) + " times";
        continue;
      }
    }
    all.push_back({event, 1, event.utc});
  }
  return all;
}

}  // namespace dwell::record
