#include "daemon/serve/traces_query.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>

#include "daemon/serve/next_part.hpp"
#include "daemon/serve/traces_json.hpp"

namespace dwell {
namespace {

template <class Number>
bool number_of(std::string_view text, Number& to) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), to);
  return error == std::errc{} && end == text.data() + text.size();
}

int hex(char c) {
  const std::string_view digits = "0123456789abcdef";
  const auto at = digits.find(static_cast<char>(c >= 'A' && c <= 'F' ? c + ('a' - 'A') : c));
  return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

// %20 and the like as the bytes they stand for.
std::string decoded(std::string_view text) {
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool code = text[i] == '%' && i + 2 < text.size() && hex(text[i + 1]) >= 0 && hex(text[i + 2]) >= 0;
    bytes += code ? static_cast<char>(16 * hex(text[i + 1]) + hex(text[i + 2])) : text[i];
    if (code) i += 2;
  }
  return bytes;
}

std::optional<std::vector<std::size_t>> channels_of(std::string_view names, const Rig& rig) {
  std::vector<std::size_t> channels;
  while (!names.empty()) {
    const std::string name = decoded(next_part(names, ','));
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
  const auto not_understood = [](std::string_view term, std::string_view why = "") {
    return tl::unexpected("\"" + std::string(term) + "\" is not understood: " + std::string(why) +
                          "expected from=SECONDS, to=SECONDS (negative: before the newest reading), points=1 to " +
                          std::to_string(kMostTracePoints) +
                          ", channels=NAME,NAME, less=steady, or several joined by &");
  };
  std::vector<std::string_view> given;
  while (!query.empty()) {
    const std::string_view term = next_part(query, '&');
    std::string_view value = term;
    const std::string_view key = next_part(value, '=');
    if (std::find(given.begin(), given.end(), key) != given.end())
      return not_understood(term, std::string(key) + " is given twice; ");
    given.push_back(key);
    if (key == "from" || key == "to") {
      double seconds = 0.0;
      if (!number_of(value, seconds) || !std::isfinite(seconds)) return not_understood(term);
      if (key == "from")
        asked.from_s = seconds;
      else
        asked.to_s = seconds;
    } else if (key == "points") {
      if (!number_of(value, asked.points) || asked.points < 1 || asked.points > kMostTracePoints)
        return not_understood(term);
    } else if (key == "channels") {
      auto channels = channels_of(value, rig);
      if (!channels) return not_understood(term);
      asked.channels = std::move(*channels);
    } else if (key == "less" && value == "steady") {
      asked.less_steady = true;
    } else {
      return not_understood(term);
    }
  }
  if (asked.channels.empty()) {
    asked.channels.resize(rig.channels.size());
    std::iota(asked.channels.begin(), asked.channels.end(), std::size_t{0});
  }
  return asked;
}

}  // namespace dwell
