#include "daemon/serve/events_json.hpp"

#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/serve/page_query.hpp"

namespace dwell {

// Oldest first: those from a number on, or the newest.
HttpReply events_answer(const ServiceView& view, std::string_view query) {
  const auto page = page_of(query, kEventsPerAnswer, {"NUMBER"});
  if (!page) return http_error(400, page.error());
  static const NewestLines kNone;
  const NewestLines& all = view.events != nullptr ? *view.events : kNone;
  const auto lines =
      page->from ? all.from(static_cast<std::uint64_t>(*page->from), page->count) : all.newest(page->count);
  Json events = Json::array();
  for (const LogLine& line : lines)
    events.push_back({{"number", line.number},
                      {"utc", record::iso_utc(line.utc_ns)},
                      {"level", to_string(line.level)},
                      {"state", json_text(line.state)},
                      {"text", line.text}});
  const std::uint64_t last = lines.empty() ? all.total() : lines.back().number;
  return {200, dump(Json{{"total", all.total()}, {"next", last + 1}, {"events", std::move(events)}})};
}

}  // namespace dwell
