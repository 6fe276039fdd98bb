#include "daemon/health.hpp"

#include <algorithm>

namespace dwell {
namespace {

constexpr std::size_t kReasonsTold = 5;  // further ones are counted: a line is to be read

// What the estimation models or leaves out by itself (held, gated, a reading overrange now and then) is no trouble.
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

Health judge_health(const Rig& rig, const Snapshot& snapshot, const gpio::Status& lines, const LogStats& log,
                    const std::string& trouble, const std::vector<std::string>& alarms) {
  Health health;
  if (!trouble.empty()) health.reasons.push_back(trouble);
  for (std::size_t i = 0; i < snapshot.channels.size(); ++i) {
    const ChannelView& channel = snapshot.channels[i];
    const std::string name = "channel " + rig.channels[i].name + ": ";
    if (channel.fault != Fault::none) {
      health.reasons.push_back(name + words(to_string(channel.fault), channel.reason));
    } else if (is_unusable(channel.condition)) {
      health.reasons.push_back(name + words(to_string(channel.condition), channel.condition_reason));
    }
  }
  for (std::size_t i = 0; i < lines.size(); ++i)
    if (lines[i].configured && !lines[i].works)
      health.reasons.push_back(std::string("GPIO ") + gpio::kFunctionNames[i] + ": " +
                               words("does not work", lines[i].reason));
  const Dwell& dwell = snapshot.dwell;
  if (dwell.state == State::fault) health.reasons.push_back(words("the data do not suffice", dwell.settling_reason));
  if (log.failing)
    health.reasons.push_back("the log loses lines, " + std::to_string(log.dropped) + " so far: " + log.reason);

  for (const std::string& alarm : alarms) health.reasons.push_back("recording: " + alarm);

  health.run = run_words(snapshot.run);

  const auto& interlock = lines[static_cast<std::size_t>(gpio::Function::interlock)];
  health.status = !trouble.empty()         ? Health::Status::fault
                  : health.reasons.empty() ? Health::Status::ok
                                           : Health::Status::degraded;
  health.ready =
      trouble.empty() && dwell.state == State::measuring && trustworthy(dwell) && interlock.level.value_or(true);
  return health;
}

std::string reason_of(const Health& health) {
  std::string line;
  const std::size_t told = std::min(health.reasons.size(), kReasonsTold);
  for (std::size_t i = 0; i < told; ++i) line += (i == 0 ? "" : "; ") + health.reasons[i];
  if (health.reasons.size() > told) line += "; and " + std::to_string(health.reasons.size() - told) + " more";
  return line;
}

}  // namespace dwell
