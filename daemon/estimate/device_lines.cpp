#include "daemon/estimate/device_lines.hpp"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace dwell {
namespace {

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

DeviceLines::DeviceLines(std::string device, double rate_hz, Log& log)
    : device_(std::move(device)), rate_hz_(rate_hz), log_(log) {}

void DeviceLines::fault(Fault fault, std::uint64_t fresh, const std::string& words, std::uint64_t occurrences,
                        std::int64_t now_ns) {
  if (!throttle(fault).admit(now_ns, fresh)) return;
  told_[static_cast<std::size_t>(fault)] = occurrences;
  std::string line = "device " + device_ + ": " + words;
  if (occurrences > 1) line += " (" + std::to_string(occurrences) + " times by now)";
  // The end of a recording is no fault.
  const Level level = fault == Fault::end_of_data ? Level::info : Level::warning;
  log_.write(level, line, {{"DWELL_DEVICE", device_}, {"DWELL_FAULT", to_string(fault)}});
}

void DeviceLines::stale(const std::vector<std::string>& channels, Fault why, const std::string& reason,
                        std::uint64_t occurrences, std::int64_t now_ns) {
  std::string words = joined(channels) + " stale, " + to_string(why);
  if (reason != to_string(why)) words += ": " + reason;
  fault(why, 1, words, occurrences, now_ns);
}

void DeviceLines::delivering(const std::vector<std::string>& channels, bool first, std::int64_t stale_ns,
                             std::int64_t now_ns) {
  const auto stands_for = throttle(Fault::none).admit(now_ns);
  if (!stands_for) return;
  std::string line = "device " + device_ + ": " + joined(channels);
  if (first) {
    line += " delivering";
  } else {
    char after[48];
    std::snprintf(after, sizeof after, " delivering again after %.1f s", static_cast<double>(stale_ns) * 1e-9);
    line += after;
  }
  if (*stands_for > 1) line += " (" + std::to_string(*stands_for) + " recoveries since the last such line)";
  log_.info(line, {{"DWELL_DEVICE", device_}});
}

void DeviceLines::counted(Fault which, std::uint64_t occurrences, std::int64_t now_ns) {
  const std::uint64_t fresh = occurrences - told_[static_cast<std::size_t>(which)];
  if (fresh > 0) fault(which, fresh, to_string(which), occurrences, now_ns);
}

void DeviceLines::missed_polls(std::uint64_t occurrences, std::int64_t now_ns) {
  const auto part = polls_.look(now_ns, occurrences, rate_hz_);
  if (!part || !throttle(Fault::missed_deadline).admit(now_ns)) return;
  char words[160];
  std::snprintf(
      words, sizeof words,
      ": %.0f %% of its polls began too late and were skipped in the last minute; a rate below %.3g Hz can be "
      "kept",
      100.0 * *part, rate_hz_ * std::max(0.0, 1.0 - *part));
  log_.warning("device " + device_ + words, {{"DWELL_DEVICE", device_}, {"DWELL_FAULT", "missed deadline"}});
}

void DeviceLines::end(std::uint64_t missed_polls) {
  if (missed_polls == 0) return;
  log_.info(
      "device " + device_ + ": " + std::to_string(missed_polls) + " polls of this run began too late and were skipped",
      {{"DWELL_DEVICE", device_}});
}

}  // namespace dwell
