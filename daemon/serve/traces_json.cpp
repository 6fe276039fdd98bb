#include "daemon/serve/traces_json.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/serve/traces_query.hpp"
#include "daemon/traces/traces.hpp"

namespace dwell {
namespace {

template <class Number>
void append(std::string& text, Number number) {
  char digits[32];
  const auto [end, error] = std::to_chars(digits, digits + sizeof digits, number);
  text.append(digits, error == std::errc{} ? end : digits);
}

// "name":[…], one entry for each that `each` yields.
template <class Each>
void append_list(std::string& text, std::string_view name, std::size_t count, Each each) {
  text.append("\"").append(name).append("\":[");
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) text += ',';
    each(i);
  }
  text += ']';
}

void append_bins(std::string& text, const std::vector<TraceBin>& bins) {
  const auto reading = [&](const TraceBin& bin, float value) {
    if (bin.empty())
      text += "null";
    else
      append(text, value);
  };
  append_list(text, "min", bins.size(), [&](std::size_t i) { reading(bins[i], bins[i].low); });
  text += ',';
  append_list(text, "max", bins.size(), [&](std::size_t i) { reading(bins[i], bins[i].high); });
  std::vector<std::size_t> breaks;
  for (std::size_t i = 0; i < bins.size(); ++i)
    if (bins[i].broken) breaks.push_back(i);
  text += ',';
  append_list(text, "breaks", breaks.size(), [&](std::size_t i) { append(text, breaks[i]); });
}

double to_s(std::int64_t ns) { return static_cast<double>(ns) / 1e9; }

// Of the current dwell, or of the one that ended last.
std::optional<SteadyPart> newest_steady_part(const ServiceView& view) {
  const Snapshot& now = view.snapshot;
  if (auto current = SteadyPart::of(now.dwell, view.rig, now.origin_ns)) return current;
  if (!now.finished) return std::nullopt;
  for (auto dwell = now.finished->rbegin(); dwell != now.finished->rend(); ++dwell)
    if (auto ended = SteadyPart::of(**dwell, view.rig, now.origin_ns)) return ended;
  return std::nullopt;
}

}  // namespace

HttpReply traces_answer(const ServiceView& view, std::string_view query) {
  const auto asked = traces_query(query, view.rig);
  if (!asked) return http_error(400, asked.error());
  if (view.traces == nullptr || view.traces->none()) return http_error(503, "nothing has come from the devices yet");
  const Traces& traces = *view.traces;
  std::optional<SteadyPart> less;
  if (asked->less_steady && !(less = newest_steady_part(view)))
    return http_error(409, "no dwell of this run has settled: there is no steady part yet to be taken out");
  const bool back = asked->from_s < 0.0;
  const double newest_s = traces.newest_s();
  const double asked_s = asked->to_s.value_or(back ? 0.0 : newest_s);
  const double until_s = asked_s <= 0.0 && back ? newest_s + asked_s : asked_s;
  const double from_s = back ? newest_s + asked->from_s : asked->from_s;
  const auto words = [](double number) {
    std::string number_text;
    append(number_text, number);
    return number_text;
  };
  if (from_s > newest_s)
    return http_error(400,
                      "from=" + words(from_s) + " is in the future: the newest record is at " + words(newest_s) + " s");
  if (until_s < from_s)
    return http_error(400, "to=" + words(until_s) + " is before from=" + words(from_s) + " (s): expected a later one");
  const auto in_all = kMostTracePointsInAll / static_cast<std::int64_t>(asked->channels.size());
  const std::int64_t points =
      std::min(asked->points > 0 ? asked->points : kTracePoints, std::max<std::int64_t>(in_all, 1));
  const Traces::BinRange stretch =
      less ? traces.stretch_of_readings(std::max(from_s, until_s - kLongestLess_s), until_s, points)
           : traces.stretch(from_s, until_s, points);

  HttpReply reply;
  std::string& text = reply.body;
  const std::int64_t origin_utc_ns = record::utc_of({view.now_ns, view.now_utc_ns}, traces.origin_ns());
  text = "{\"origin_utc\":" + dump(record::iso_utc(origin_utc_ns)) + ",\"newest_s\":";
  append(text, traces.newest_s());
  text += ",\"step_s\":";
  append(text, to_s(stretch.step_ns));
  text += ",\"from_s\":";
  append(text, to_s(stretch.first * stretch.step_ns));
  text += ",\"bins\":";
  append(text, stretch.count);
  text += ",\"less_dwell\":" + (less ? std::to_string(less->dwell()) : "null") + ",\"less_from_s\":";
  if (less)
    append(text, traces.seconds(less->fitted_from_ns()));
  else
    text += "null";
  text += ',';
  append_list(text, "channels", asked->channels.size(), [&](std::size_t i) {
    const std::size_t channel = asked->channels[i];
    text += "{\"name\":" + dump(view.rig.channels[channel].name) +
            ",\"unit\":" + dump(view.rig.channels[channel].unit) + ',';
    append_bins(text, less ? traces.read_less(stretch, channel, *less) : traces.read(stretch, channel));
    text += '}';
  });
  text += '}';
  return reply;
}

std::string traces_event(const Traces& traces, std::int64_t first, std::size_t channels) {
  const std::int64_t from = std::max(first, traces.oldest()),
                     count = std::max<std::int64_t>(traces.complete() - from, 0);
  std::string text = "{\"step_s\":";
  append(text, to_s(Traces::kBin_ns));
  text += ",\"first\":";
  append(text, from);
  text += ",\"bins\":";
  append(text, count);
  text += ',';
  std::vector<TraceBin> bins(static_cast<std::size_t>(count));
  append_list(text, "channels", channels, [&](std::size_t channel) {
    for (std::int64_t i = 0; i < count; ++i) bins[static_cast<std::size_t>(i)] = traces.bin(channel, from + i);
    text += '{';
    append_bins(text, bins);
    text += '}';
  });
  text += '}';
  return text;
}

}  // namespace dwell
