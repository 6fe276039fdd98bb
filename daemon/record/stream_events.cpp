#include "daemon/record/stream_events.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dwell::record {
namespace {

// Most changes of state kept between two calls: bounds what a hostile or broken stream takes.
constexpr std::size_t kMostStates = 1000;

std::string named(const char* what, const std::vector<std::string>& names, std::size_t index) {
  return std::string(what) + " " + (index < names.size() ? names[index] : std::to_string(index));
}

StoredEvent made(const char* what, std::uint64_t position, std::string utc, std::string text) {
  StoredEvent event;
  event.position = position;
  event.utc = std::move(utc);
  event.what = what;
  event.text = std::move(text);
  return event;
}

}  // namespace

const char* loss_text(Loss loss) noexcept {
  switch (loss) {
    case Loss::refused:
      return "the ring between driver and estimation was full";
    case Loss::late:
      return "older than records already used";
    case Loss::ahead:
      return "stamped ahead of the clock";
    case Loss::overflow:
      return "the merger was full";
  }
  return "unknown";
}

void StreamEvents::take(const Record& record, std::uint64_t position) {
  if (record.kind == Kind::channel_state && states_.size() < kMostStates) {
    states_.emplace_back(position, record);
    return;
  }
  Key key{record.kind, record.channel, record.flags};
  double times = record.value;
  if (record.kind == Kind::channel_state) {  // all that find no room together
    key = {record.kind, 0, 0};
    times = 1.0;
  } else if (record.kind != Kind::loss && record.kind != Kind::fault) {
    return;
  }
  Count& count = counts_[key];
  if (count.times == 0) {
    count.position = position;
    count.t_ns = record.t_ns;
  }
  count.times += static_cast<std::uint64_t>(std::isfinite(times) ? std::max(times, 1.0) : 1.0);
}

std::vector<StoredEvent> StreamEvents::drain(const StreamNames& names,
                                             const std::function<std::string(std::int64_t)>& utc) {
  std::vector<StoredEvent> events;
  for (const auto& [position, record] : states_) {
    const auto fault = static_cast<Fault>(record.flags);
    events.push_back(
        made("fault", position, utc(record.t_ns),
             named("channel", names.channels, record.channel) +
                 (fault == Fault::none ? " delivers" : std::string(" does not deliver: ") + to_string(fault))));
  }
  for (const auto& [key, count] : counts_) {
    const auto& [kind, index, flag] = key;
    const std::string times = std::to_string(count.times);
    if (kind == Kind::channel_state) {
      events.push_back(made("fault", count.position, utc(count.t_ns),
                            times + " more changes of channels' states within a second are not told one by one; the "
                                    "stream holds them"));
    } else if (kind == Kind::loss) {
      events.push_back(made("loss", count.position, utc(count.t_ns),
                            named("channel", names.channels, index) + ": " + times + " samples lost, " +
                                loss_text(static_cast<Loss>(flag))));
    } else {
      events.push_back(made("fault", count.position, utc(count.t_ns),
                            named("device", names.devices, index) + ": " + to_string(static_cast<Fault>(flag)) + ", " +
                                times + " times"));
    }
  }
  states_.clear();
  counts_.clear();
  std::stable_sort(events.begin(), events.end(),
                   [](const StoredEvent& a, const StoredEvent& b) { return a.position < b.position; });
  return events;
}

}  // namespace dwell::record
