#include "daemon/health.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/rig/limit.hpp"
#include "daemon/calibration.hpp"
#include "daemon/freshness.hpp"
#include "daemon/report/limit_text.hpp"

namespace dwell {
namespace {

constexpr std::size_t kReasonsTold = 5;  // further ones are counted: a line is to be read

// Readings that the estimation models or leaves out by itself (held, gated, overrange now and then) are no trouble.
bool is_unusable(Condition condition) { return condition == Condition::clipped || condition == Condition::stuck; }

std::string words(const char* what, const std::string& why) { return why.empty() || why == what ? what : why; }

const char* run_words(const RunView& run) {
  if (!run.bracketed) return "not recorded: the rig file has no [recording]";
  if (run.on) return run.by_operator ? "an operator's run goes on" : "a run of the drive goes on";
  if (run.held)
    return "no run goes on: it was stopped; the next begins with \"dwellctl start\", or with the drive once it has "
           "rested";
  return "no run goes on: the next begins with the drive, or with \"dwellctl start\"";
}

// Whether the device has several channels and none of them delivers. Then the device is told, not its channels. A
// device's only channel is told by its own name.
bool is_dead(const Rig& rig, const Snapshot& snapshot, int device) {
  if (device < 0 || static_cast<std::size_t>(device) >= snapshot.devices.size()) return false;
  return !snapshot.devices[static_cast<std::size_t>(device)].up &&
         std::count_if(rig.channels.begin(), rig.channels.end(),
                       [device](const Channel& channel) { return channel.device == device; }) > 1;
}

Trouble of_channel(const Channel& channel, const std::string& why) {
  return {
      "channel:" + channel.name, "channel " + channel.name + ": " + why, true, TroubleKind::channel, channel.name, why};
}

void add_channels(const Rig& rig, const Snapshot& snapshot, std::vector<Trouble>& troubles) {
  std::vector<int> told;  // devices
  for (std::size_t i = 0; i < snapshot.channels.size(); ++i) {
    const ChannelView& view = snapshot.channels[i];
    const Channel& channel = rig.channels[i];
    if (view.fault == Fault::end_of_data) continue;  // a recording was played to its end: nothing is wrong
    if (view.fault != Fault::none && is_dead(rig, snapshot, channel.device)) {
      if (std::find(told.begin(), told.end(), channel.device) != told.end()) continue;
      told.push_back(channel.device);
      const std::string& device = snapshot.devices[static_cast<std::size_t>(channel.device)].name;
      troubles.push_back({"device:" + device,
                          "device " + device + " does not deliver: " + words(to_string(view.fault), view.reason), true,
                          TroubleKind::device});
    } else if (view.fault != Fault::none) {
      troubles.push_back(of_channel(channel, words(to_string(view.fault), view.reason)));
    } else if (is_unusable(view.condition)) {
      troubles.push_back(of_channel(channel, words(to_string(view.condition), view.condition_reason)));
    }
  }
}

// Channels that deliver, and yet the dwell that is measured does not use them. For instance one that was stuck for a
// while: its good readings are too few of all. The dwell then withholds elements.
void add_unused(const Rig& rig, const Snapshot& snapshot, std::vector<Trouble>& troubles) {
  const Dwell& dwell = snapshot.dwell;
  for (std::size_t i = 0; i < std::min(snapshot.channels.size(), dwell.phasors.size()); ++i) {
    const ChannelView& view = snapshot.channels[i];
    const Channel& channel = rig.channels[i];
    const bool told = view.fault != Fault::none || is_unusable(view.condition);
    if (told || dwell.phasors[i].valid || channel.measures == Quantity::auxiliary) continue;
    troubles.push_back(of_channel(channel, "not counted in this dwell: " + dwell.phasors[i].reason));
  }
  if (std::isfinite(dwell.settled_s) && dwell.elements.empty())
    troubles.push_back({"dwell", "no coefficients: " + words("the data do not suffice", dwell.settling_reason), true,
                        TroubleKind::dwell});
}

// Whether all devices are recordings that were played to their end. Then no drive is seen, as is to be expected.
bool has_ended(const Snapshot& snapshot) {
  return !snapshot.devices.empty() && std::all_of(snapshot.devices.begin(), snapshot.devices.end(),
                                                  [](const DeviceView& device) { return device.ended; });
}

// Adds the gated channels of a dwell that settles. Foreign readings that pass the gates look like a transient, and may
// keep the dwell from settling. A channel does not count if a sound one measures the same.
void add_gated(const Rig& rig, const Snapshot& snapshot, std::vector<Trouble>& troubles) {
  const auto gated = [&](std::size_t i) {
    return snapshot.channels[i].fault == Fault::none && snapshot.channels[i].condition == Condition::gated;
  };
  const auto stands_in = [&](std::size_t other, const Channel& channel) {
    const Channel& with = rig.channels[other];
    const ChannelView& view = snapshot.channels[other];
    return with.at == channel.at && with.relative_to == channel.relative_to &&
           (with.measures == Quantity::force) == (channel.measures == Quantity::force) &&
           with.measures != Quantity::auxiliary && view.fault == Fault::none && !is_unusable(view.condition) &&
           view.condition != Condition::gated;
  };
  for (std::size_t i = 0; i < snapshot.channels.size(); ++i) {
    const Channel& channel = rig.channels[i];
    if (!gated(i) || channel.measures == Quantity::auxiliary) continue;
    bool replaced = false;
    for (std::size_t other = 0; other < snapshot.channels.size(); ++other)
      replaced = replaced || stands_in(other, channel);
    if (replaced) continue;
    const ChannelView& view = snapshot.channels[i];
    troubles.push_back(of_channel(channel, words(to_string(view.condition), view.condition_reason)));
  }
}

// A violated limit is a trouble. While a dwell goes on, it is unknown whether a limit without a verdict is still
// violated: an alarm that ended there would begin anew with the next number.
void add_limits(const Rig& rig, const Snapshot& snapshot, bool stale, Health& health) {
  const Dwell& dwell = snapshot.dwell;
  const bool goes_on = dwell.state == State::settling || dwell.state == State::measuring ||
                       (dwell.state == State::fault && !has_ended(snapshot));
  for (const JudgedLimit& limit : judge_limits_now(rig, dwell)) {
    Trouble trouble{std::string("limit:") + to_string(limit.kind) + ":" + std::to_string(limit.element), "", true,
                    TroubleKind::limit};
    if (!stale && limit.verdict == LimitVerdict::violated) {
      trouble.text = "limit violated: " + violation_text(limit, dwell, rig.motion);
      health.troubles.push_back(std::move(trouble));
    } else if (goes_on && (stale || limit.verdict == LimitVerdict::none)) {
      trouble.text = "limit was violated; no verdict now on the " + limited_text(limit) + ": " +
                     (stale ? "the estimate is stale" : limit.reason);
      health.unknown.push_back(std::move(trouble));
    }
  }
}

bool none_degrades(const Health& health) {
  return std::none_of(health.troubles.begin(), health.troubles.end(), [](const Trouble& t) { return t.degrades; });
}

}  // namespace

const char* to_string(Health::Status status) noexcept {
  switch (status) {
    case Health::Status::ok:
      return "ok";
    case Health::Status::degraded:
      return "degraded";
    case Health::Status::fault:
      return "fault";
  }
  return "?";
}

const char* to_string(TroubleKind kind) noexcept {
  switch (kind) {
    case TroubleKind::service:
      return "service";
    case TroubleKind::channel:
      return "channel";
    case TroubleKind::device:
      return "device";
    case TroubleKind::gpio:
      return "gpio";
    case TroubleKind::dwell:
      return "dwell";
    case TroubleKind::limit:
      return "limit";
    case TroubleKind::log:
      return "log";
    case TroubleKind::recording:
      return "recording";
    case TroubleKind::clock:
      return "clock";
    case TroubleKind::calibration:
      return "calibration";
  }
  return "?";
}

double estimate_age_s(const Snapshot& snapshot, std::int64_t now_ns) noexcept {
  if (snapshot.sequence == 0) return std::numeric_limits<double>::infinity();
  return std::max(0.0, static_cast<double>(now_ns - snapshot.t_ns) * 1e-9);
}

bool is_overdue(const Snapshot& snapshot, std::int64_t now_ns) noexcept {
  return estimate_age_s(snapshot, now_ns) > kOldAfter_s;
}

Health judge_health(const Rig& rig, const Snapshot& snapshot, std::int64_t now_ns, const gpio::Status& lines,
                    const LogStats& log, const std::string& trouble, const std::vector<record::RecorderAlarm>& recorder,
                    bool clock_synchronized, std::int64_t utc_ns) {
  Health health;
  const auto add = [&](TroubleKind kind, std::string name, std::string text) {
    health.troubles.push_back({std::move(name), std::move(text), true, kind});
  };
  if (!trouble.empty()) add(TroubleKind::service, kServiceTrouble, trouble);
  add_channels(rig, snapshot, health.troubles);
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (lines[i].configured && !lines[i].works)
      add(TroubleKind::gpio, std::string("gpio:") + gpio::kFunctionNames[i],
          std::string("GPIO ") + gpio::kFunctionNames[i] + ": " + words("does not work", lines[i].reason));
  const Dwell& dwell = snapshot.dwell;
  if (dwell.state == State::fault && !has_ended(snapshot))
    add(TroubleKind::dwell, "dwell", words("the data do not suffice", dwell.settling_reason));
  const bool stale = !trouble.empty() || is_overdue(snapshot, now_ns);
  if (!stale && dwell.state == State::measuring) add_unused(rig, snapshot, health.troubles);
  if (!stale && dwell.state == State::settling) add_gated(rig, snapshot, health.troubles);
  add_limits(rig, snapshot, stale, health);
  if (log.failing)
    add(TroubleKind::log, "log", "the log loses lines, " + std::to_string(log.dropped) + " so far: " + log.reason);
  for (const record::RecorderAlarm& alarm : recorder) add(TroubleKind::recording, alarm.name, alarm.text);
  // Dates in records may be wrong. The numbers are not: they are computed on the raw clock, whose rate has an
  // uncertainty of its own.
  if (!clock_synchronized)
    health.troubles.push_back(
        {"clock", "the computer's clock is not synchronized: dates may be wrong, coefficients are not affected", false,
         TroubleKind::clock});

  // The readings are as good as before, but no valid certificate proves their scale: an alarm that does not degrade.
  for (const Channel& channel : rig.channels)
    if (clock_synchronized && calibration_overdue(channel, utc_ns).value_or(false))
      health.troubles.push_back({"calibration:" + channel.name,
                                 "channel " + channel.name + ": the calibration " + channel.calibration.id +
                                     " is overdue: it was due on " + channel.calibration.due,
                                 false, TroubleKind::calibration, channel.name});

  health.run = run_words(snapshot.run);

  const auto& interlock = lines[static_cast<std::size_t>(gpio::Function::interlock)];
  health.status = !trouble.empty()        ? Health::Status::fault
                  : none_degrades(health) ? Health::Status::ok
                                          : Health::Status::degraded;
  health.ready = !stale && dwell.state == State::measuring && trustworthy(dwell) && interlock.level.value_or(true);
  return health;
}

std::string reason_of(const Health& health) {
  std::string line;
  std::size_t told = 0, more = 0;
  for (const Trouble& trouble : health.troubles) {
    if (!trouble.degrades) continue;
    if (told == kReasonsTold) {
      ++more;
      continue;
    }
    line += (told++ == 0 ? "" : "; ") + trouble.text;
  }
  if (more > 0) line += "; and " + std::to_string(more) + " more";
  return line;
}

}  // namespace dwell
