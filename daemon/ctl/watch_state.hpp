// What watch knows of the service, and since when: the state that its screen is drawn from. Instants are seconds of one
// monotonic clock, given by the caller, so that it can be tested without waiting.
//
// Bound to one thread, not real-time.
#pragma once

#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ctl/alarm_table.hpp"
#include "daemon/ctl/trend.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell::ctl {

inline constexpr double kNever = -std::numeric_limits<double>::infinity();

// How a channel stands by the service's list of channels.
struct ChannelState {
  std::string name;
  std::string status;   // empty: well; else the status word, and the reason behind a colon
  double age_s = kNaN;  // of its newest reading, when the list was made
};
[[nodiscard]] std::vector<ChannelState> channel_states(const nlohmann::ordered_json& list);

class WatchState {
 public:
  // Numbers that are older than this are shown as old, if they are usually renewed more often, s. The service tells the
  // whole dwell once a second, so one late message is no alarm and two missing ones are. Halved: a busy network makes
  // the screen flicker grey. Doubled: an operator looks at dead numbers for so much longer.
  static constexpr double kOld_s = 2.5;
  // … else where this many of the usual times between renewals have passed.
  static constexpr double kUsualTimes = 2.5;

  // A dwell that the service told.
  void take(DwellView dwell, double now_s);
  void take(std::vector<ChannelState> channels, double now_s);

  // Since the dwell's data last moved on; while there are none: since anything was heard.
  [[nodiscard]] double age_s(double now_s) const;
  // Since the service last said anything of the dwell.
  [[nodiscard]] double silent_s(double now_s) const { return now_s - heard_s_; }
  // Whether the numbers are no longer renewed: not for long, or not at all since the connection is gone.
  [[nodiscard]] bool old(double now_s) const { return !trouble.empty() || age_s(now_s) > old_after_s(); }
  [[nodiscard]] bool silent(double now_s) const { return silent_s(now_s) > old_after_s(); }
  [[nodiscard]] double old_after_s() const;

  [[nodiscard]] const std::optional<DwellView>& dwell() const noexcept { return dwell_; }
  // How the channel of this name stands, its age as of now; nothing: not known, or known no longer.
  [[nodiscard]] std::optional<ChannelState> channel(const std::string& asked, double now_s) const;
  // Since the channels' list was made; infinite: never.
  [[nodiscard]] double channels_age_s(double now_s) const { return now_s - channels_s_; }

  // Of the dwells that were taken.
  [[nodiscard]] const Trend& trend() const noexcept { return trend_; }

  std::string name;     // of the rig, or the service's address
  std::string trouble;  // what is wrong with the connection; empty: nothing
  std::string gpio;     // what is to be known of the GPIO lines, as lines
  AlarmsList alarms;

 private:
  std::optional<DwellView> dwell_;
  double heard_s_ = kNever;
  double moved_s_ = kNever;
  double turn_s_[3] = {0.0, 0.0, 0.0};  // times between the last renewals, newest first
  Trend trend_;
  std::vector<ChannelState> channels_;
  double channels_s_ = kNever;
};

}  // namespace dwell::ctl
