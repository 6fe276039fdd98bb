// What watch knows of the service, and since when: the state that its screen is drawn from. Instants are seconds of one
// monotonic clock, given by the caller, so that it can be tested without waiting.
//
// Bound to one thread, not real-time.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ctl/alarm_table.hpp"
#include "daemon/ctl/trend.hpp"
#include "daemon/freshness.hpp"
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

// What the service says of why a model has no verdict yet.
struct WhyUnverified {
  std::optional<int> dwell;  // that it is about; none: the one in view
  std::string reason;        // the first; empty: none is stated
};
[[nodiscard]] WhyUnverified why_unverified(const nlohmann::ordered_json& verification);

// The run by the service's health, as the page has it: "run 17, “label”", "no run goes on", "not recorded"; empty: not
// told.
[[nodiscard]] std::string run_text(const nlohmann::ordered_json& health);

// Whether the service plays a recording by its health, and how far.
enum class Played : std::uint8_t { none, going_on, to_its_end };
[[nodiscard]] Played played(const nlohmann::ordered_json& health);

// Since when the service is in this state by the list of its events, ns of UTC; nullopt: they do not tell.
[[nodiscard]] std::optional<std::int64_t> state_since(const nlohmann::ordered_json& events, State state);

// The newest answer to a question, and when it came.
template <class Value>
struct Heard {
  Value value{};
  double at_s = kNever;
};

// When the dwell in view was renewed.
class Renewals {
 public:
  void told(double now_s) noexcept { told_s_ = now_s; }
  // Its data moved on.
  void moved(double now_s) noexcept;
  [[nodiscard]] double told_s() const noexcept { return told_s_; }
  [[nodiscard]] double moved_s() const noexcept { return moved_s_; }
  // Age from which its numbers are old, s.
  [[nodiscard]] double old_after_s() const noexcept;

 private:
  double told_s_ = kNever, moved_s_ = kNever;
  double turn_s_[3] = {0.0, 0.0, 0.0};  // times between the last renewals, newest first
};

enum class Silence : std::uint8_t {
  service,     // it says nothing at all
  estimation,  // the service answers, but its estimation publishes nothing
  data,        // the estimation publishes, but always the same data
};

class WatchState {
 public:
  // Lists older than this are shown as old, s. They are asked for once a second, and after a question without an answer
  // 10 s later: at least one had none.
  static constexpr double kListOld_s = 2.0 * kOldAfter_s;

  // now_s of every call: s, on one clock that never steps back.

  // A dwell that the stream told; its age, where it has one, counts from what the service says.
  void take(DwellView dwell, double now_s);
  // Answers to what is asked beside the stream.
  void take(std::vector<ChannelState> channels, double now_s);
  void take(AlarmsList alarms, double now_s);
  void take(WhyUnverified why) { unverified_ = std::move(why); }
  // What time the service has, ns of UTC: how long ago a dwell ended is told by it.
  void take_utc(std::int64_t utc_ns, double now_s);
  // What is to be known of the GPIO lines, as lines that end with a newline each.
  void take_gpio(std::string lines, double now_s);
  // The newest dwell that has ended, as the service's list has it.
  void take_last(DwellView dwell);
  // The rig that the service serves, and the SHA-256 of its file. true: it is another file than before; then what is
  // known of dwells is of that one, and is forgotten.
  bool take_rig(std::string called, std::string sha256);
  void take_run(std::string text) { run_ = std::move(text); }
  void take_played(Played played) { played_ = played; }
  // Runs of the last hour that the trend lacks, since their dwells are not told: "run 7".
  void take_lacking(std::vector<std::string> runs) { trend_.take_lacking(std::move(runs)); }
  // Since when the service is in this state, where the dwell does not tell it.
  void take_since(State state, std::int64_t utc_ns) { since_ = {state, utc_ns}; }
  // The dwells that ended before the stream began, while it was lost, or meanwhile.
  void take(const std::vector<EarlierDwell>& dwells, double now_s) { trend_.take_earlier(dwells, now_s); }

  // Since the dwell's data last moved on, s; while there are none: since it was published. Infinite: no dwell yet.
  [[nodiscard]] double age_s(double now_s) const;
  // Since the service last said anything, by the stream or by an answer, s. Infinite: it never has.
  [[nodiscard]] double silent_s(double now_s) const { return now_s - heard_s_; }
  // Whether the numbers are no longer renewed: by the service's word, for long, or since the connection is gone.
  [[nodiscard]] bool old(double now_s) const;
  // Whether the dwell in view has ended. Then the run was stopped: its numbers are a result, which is not renewed.
  [[nodiscard]] bool ended() const { return dwell_ && dwell_->dwell.state == State::complete; }
  // Since the end of its data, s; NaN: not known.
  [[nodiscard]] double ended_ago_s(double now_s) const;
  [[nodiscard]] bool silent(double now_s) const { return silent_s(now_s) > old_after_s(); }
  // Who is silent where the numbers are old.
  [[nodiscard]] Silence silence(double now_s) const;
  // Age from which numbers are old, s.
  [[nodiscard]] double old_after_s() const { return renewals_.old_after_s(); }

  [[nodiscard]] const std::optional<DwellView>& dwell() const noexcept { return dwell_; }
  // How the channel of this name stands, its age as of now; nothing: not known, or known no longer.
  [[nodiscard]] std::optional<ChannelState> channel(const std::string& asked, double now_s) const;
  // Since the channels' list was made, s; infinite: never.
  [[nodiscard]] double channels_age_s(double now_s) const { return now_s - channels_.at_s; }

  [[nodiscard]] const AlarmsList& alarms() const noexcept { return alarms_.value; }
  [[nodiscard]] bool alarms_old(double now_s) const { return list_old(alarms_.at_s, now_s); }
  [[nodiscard]] const std::string& gpio() const noexcept { return gpio_.value; }
  [[nodiscard]] bool gpio_old(double now_s) const { return list_old(gpio_.at_s, now_s); }

  // Why the model of the dwell in view has no verdict yet; empty: it has one, or nothing is known of it.
  [[nodiscard]] std::string why_unverified() const;

  // Of the dwells that were taken.
  [[nodiscard]] const Trend& trend() const noexcept { return trend_; }
  // Since the end of the dwell with which that in view is compared, s; NaN: not known.
  [[nodiscard]] double before_ago_s(double now_s) const;

  // The newest dwell that gave coefficients, while that in view is none (idle, fault); null: none is known.
  [[nodiscard]] const DwellView* last() const;
  // Since the end of its data, s; NaN: not known.
  [[nodiscard]] double last_ago_s(double now_s) const { return last_ ? data_ago_s(*last_, now_s) : kNaN; }

  [[nodiscard]] const std::string& run() const noexcept { return run_; }
  [[nodiscard]] Played played() const noexcept { return played_; }
  // When the state in view began, ns of UTC; nullopt: not known.
  [[nodiscard]] std::optional<std::int64_t> since_utc_ns() const;
  // The service's time of day, ns of UTC; nullopt: not known.
  [[nodiscard]] std::optional<std::int64_t> utc_ns(double now_s) const;

  std::string name;     // of the rig, or the service's address
  std::string trouble;  // what is wrong with the connection; empty: nothing

 private:
  [[nodiscard]] bool list_old(double heard_s, double now_s) const {
    return !trouble.empty() || now_s - heard_s > kListOld_s;
  }
  // The limits of the current dwell lose their verdicts when it ends. Those told before are kept where the numbers are
  // the same.
  void keep_verdicts(DwellView& ended) const;
  // Time since t_s on the axis of the run that began at start_utc, by the service's clock, s; NaN: not known.
  [[nodiscard]] double ago_s(const std::string& start_utc, double t_s, double now_s) const;
  // How old the dwell's newest data are.
  [[nodiscard]] double data_ago_s(const DwellView& view, double now_s) const {
    return ago_s(view.run.start_utc, view.dwell.end_s, now_s);
  }
  [[nodiscard]] bool stale() const { return dwell_ && dwell_->age && dwell_->age->stale; }

  std::optional<DwellView> dwell_, last_;
  std::optional<WhyUnverified> unverified_;
  Heard<std::optional<std::int64_t>> utc_ns_;  // of the service
  double heard_s_ = kNever;                    // anything
  Renewals renewals_;
  Trend trend_;
  std::string run_;
  Played played_ = Played::none;
  std::string rig_;  // SHA-256 of its file; empty: not told yet
  std::optional<std::pair<State, std::int64_t>> since_;
  Heard<std::vector<ChannelState>> channels_;
  Heard<AlarmsList> alarms_;
  Heard<std::string> gpio_;
};

}  // namespace dwell::ctl
