#include "daemon/serve/traces_query.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>

#include "daemon/serve/next_part.hpp"
#include "daemon/serve/query.hpp"
#include "daemon/serve/traces_json.hpp"

namespace dwell {
namespace {

template <class Number>
bool number_of(std::string_view text, Number& to) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), to);
  return error == std::errc{} && end == text.data() + text.size();
}

bool seconds_of(std::string_view text, double& to_s) { return number_of(text, to_s) && std::isfinite(to_s); }

std::optional<std::vector<std::size_t>> channels_of(std::string_view names, const Rig& rig) {
  std::vector<std::size_t> channels;
  while (!names.empty()) {
    const std::string name = percent_decoded(next_part(names, ','));
    const auto found = std::find_if(rig.channels.begin(), rig.channels.end(),
                                    [&](const Channel& channel) { return channel.name == name; });
    const auto index = static_cast<std::size_t>(found - rig.channels.begin());
    if (found == rig.channels.end() || std::find(channels.begin(), channels.end(), index) != channels.end())
      return std::nullopt;
    channels.push_back(index);
  }
  if (channels.empty()) return std::nullopt;
  return channels;
}

}  // namespace

tl::expected<TracesQuery, std::string> traces_query(std::string_view query, const Rig& rig) {
  TracesQuery asked;
  const std::vector<QueryKey> understood{
      {"from", "from=SECONDS", [&](std::string_view value) { return seconds_of(value, asked.from_s); }},
      {"to", "to=SECONDS (negative: before the newest reading)",
       [&](std::string_view value) { return seconds_of(value, asked.to_s.emplace()); }},
      {"points", "points=1 to " + std::to_string(kMostTracePoints),
       [&](std::string_view value) {
         return number_of(value, asked.points) && asked.points >= 1 && asked.points <= kMostTracePoints;
       }},
      {"channels", "channels=NAME,NAME",
       [&](std::string_view value) {
         auto channels = channels_of(value, rig);
         if (channels) asked.channels = std::move(*channels);
         return channels.has_value();
       }},
      {"less", "less=steady", [&](std::string_view value) { return asked.less_steady = value == "steady"; }}};
  if (auto fault = query_fault(query, understood)) return tl::unexpected(std::move(*fault));
  if (asked.channels.empty()) {
    asked.channels.resize(rig.channels.size());
    std::iota(asked.channels.begin(), asked.channels.end(), std::size_t{0});
  }
  return asked;
}

}  // namespace dwell
