#include "daemon/ctl/watch_state.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace dwell::ctl {
namespace {

using Json = nlohmann::ordered_json;

std::string member_text(const Json& object, const char* name) {
  const auto it = object.is_object() ? object.find(name) : object.end();
  return it != object.end() && it->is_string() ? it->get<std::string>() : "";
}

// Whether there are data that ought to move on: while idle, or where the drive is not seen, there are none.
bool has_data(const Dwell& dwell) {
  return std::isfinite(dwell.settled_s) || dwell.state == State::settling || dwell.state == State::measuring;
}

// Whether the dwell that came holds other data than the one before.
bool moved(const Dwell& before, const Dwell& after) {
  return before.index != after.index || before.state != after.state || !(before.end_s == after.end_s);
}

}  // namespace

std::vector<ChannelState> channel_states(const Json& list) {
  std::vector<ChannelState> channels;
  if (!list.is_array()) return channels;
  for (const Json& item : list) {
    ChannelState channel;
    channel.name = member_text(item, "name");
    channel.status = member_text(item, "status");
    if (channel.status == "ok") channel.status.clear();
    const std::string reason = member_text(item, "reason");
    if (!reason.empty() && reason != channel.status) channel.status += (channel.status.empty() ? "" : ": ") + reason;
    const auto age = item.is_object() ? item.find("age_s") : item.end();
    if (age != item.end() && age->is_number()) channel.age_s = age->get<double>();
    channels.push_back(std::move(channel));
  }
  return channels;
}

void WatchState::take(DwellView dwell, double now_s) {
  if (!dwell_ || !has_data(dwell.dwell) || moved(dwell_->dwell, dwell.dwell)) {
    std::rotate(turn_s_, turn_s_ + 2, turn_s_ + 3);
    turn_s_[0] = std::isfinite(moved_s_) ? now_s - moved_s_ : 0.0;
    moved_s_ = now_s;
  }
  heard_s_ = now_s;
  trend_.take(dwell, now_s);
  dwell_ = std::move(dwell);
}

void WatchState::take(std::vector<ChannelState> channels, double now_s) {
  channels_ = std::move(channels);
  channels_s_ = now_s;
}

// One outage among three renewals must not pass as usual: the shortest counts.
double WatchState::old_after_s() const {
  return std::max(kOld_s, kUsualTimes * *std::min_element(turn_s_, turn_s_ + 3));
}

double WatchState::age_s(double now_s) const { return now_s - moved_s_; }

std::optional<ChannelState> WatchState::channel(const std::string& asked, double now_s) const {
  const auto found =
      std::find_if(channels_.begin(), channels_.end(), [&asked](const ChannelState& c) { return c.name == asked; });
  if (found == channels_.end()) return std::nullopt;
  ChannelState channel = *found;
  channel.age_s += channels_age_s(now_s);
  return channel;
}

}  // namespace dwell::ctl
