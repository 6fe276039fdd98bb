#include "tests/rigsim/reading_faults.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/rigsim/device.hpp"
#include "tests/rigsim/stations.hpp"

namespace rigsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSlowest_s = 3600.0;
constexpr double kMostReach = 1e6;

std::optional<int> station_number(const std::string& word) {
  const auto value = number(word);
  if (!value || *value < 1 || *value > kStations || *value != std::floor(*value)) return std::nullopt;
  return static_cast<int>(*value);
}

std::optional<double> within(const std::string& word, double low, double high) {
  const auto value = number(word);
  return value && *value >= low && *value <= high ? value : std::nullopt;
}

}  // namespace

ReadingFaults::ReadingFaults(std::vector<std::string> channels, std::vector<double> full)
    : channels_(std::move(channels)), full_(std::move(full)), lines_(channels_.size(), {0.0, -kInfinity, kInfinity}) {}

std::optional<std::size_t> ReadingFaults::find(const std::string& channel) const {
  const auto found = std::find(channels_.begin(), channels_.end(), channel);
  if (found == channels_.end()) return std::nullopt;
  return static_cast<std::size_t>(found - channels_.begin());
}

std::string ReadingFaults::set_refresh(const std::string& target, double seconds) {
  if (target == "all")
    refresh_s_ = seconds;
  else if (const auto channel = find(target))
    lines_[*channel].refresh_s = seconds;
  else if (const auto station = station_number(target))
    station_refresh_s_[*station] = seconds;
  else
    return "no channel or station " + target;
  return {};
}

std::string ReadingFaults::set_sample(const std::string& target, const std::string& moment) {
  const auto station = station_number(target);
  if (target != "all" && !station) return "no station " + target;
  const double part = moment == "request" ? 0.0 : moment == "middle" ? 0.5 : moment == "answer" ? 1.0 : -1.0;
  if (part < 0) return "expected: request, middle or answer, found " + moment;
  (station ? station_sampled_at_[*station] : sampled_at_) = part;
  return {};
}

std::optional<std::string> ReadingFaults::command(const std::vector<std::string>& words) {
  const std::string& verb = words[0];
  if (verb == "sample") {
    if (words.size() != 3) return "expected: sample all|STATION request|middle|answer";
    return set_sample(words[1], words[2]);
  }
  if (verb == "refresh") {
    const auto seconds = words.size() == 3 ? within(words[2], 0.0, kSlowest_s) : std::nullopt;
    if (!seconds) return "expected: refresh all|CHANNEL|STATION S, at most 3600";
    return set_refresh(words[1], *seconds);
  }
  if (verb == "zeros" || verb == "repeats") {
    const auto part = words.size() == 3 ? within(words[2], 0.0, 1.0) : std::nullopt;
    if (!part) return "expected: " + verb + " all|CHANNEL P, 0 to 1";
    const auto channel = find(words[1]);
    if (!channel && words[1] != "all") return "no channel " + words[1];
    if (verb == "zeros")
      (channel ? lines_[*channel].zeros : zeros_) = *part;
    else
      (channel ? lines_[*channel].repeats : repeats_) = *part;
    return std::string();
  }
  if (verb == "clip") {
    const auto low = words.size() == 4 ? within(words[2], -kMostReach, kMostReach) : std::nullopt;
    const auto high = words.size() == 4 ? within(words[3], -kMostReach, kMostReach) : std::nullopt;
    if (!low || !high || !(*low < *high)) return "expected: clip CHANNEL LOW HIGH, in steady amplitudes";
    const auto channel = find(words[1]);
    if (!channel) return "no channel " + words[1];
    lines_[*channel].low = *low * full_[*channel];
    lines_[*channel].high = *high * full_[*channel];
    return std::string();
  }
  if (verb == "converter") {
    const auto bits = words.size() == 4 ? within(words[2], 0, 32) : std::nullopt;
    const auto reach = words.size() == 4 ? within(words[3], 1e-6, kMostReach) : std::nullopt;
    if (!bits || !reach || *bits != std::floor(*bits))
      return "expected: converter CHANNEL BITS REACH, at most 32 bits (0: none), the reach in steady amplitudes";
    const auto channel = find(words[1]);
    if (!channel) return "no channel " + words[1];
    lines_[*channel].bits = static_cast<int>(*bits);
    lines_[*channel].reach = *reach * full_[*channel];
    return std::string();
  }
  return std::nullopt;
}

std::optional<double> ReadingFaults::taken_at(std::size_t channel, int station, double t_s) const {
  double refresh_s = refresh_s_;
  if (const auto of = station_refresh_s_.find(station); of != station_refresh_s_.end()) refresh_s = of->second;
  if (lines_[channel].refresh_s > 0) refresh_s = lines_[channel].refresh_s;
  if (!(refresh_s > 0)) return std::nullopt;
  return refresh_s * std::floor(t_s / refresh_s);
}

double ReadingFaults::converted(std::size_t channel, double value) const {
  const Line& line = lines_[channel];
  value = std::clamp(value, line.low, line.high);
  if (line.bits == 0 || !(line.reach > 0)) return value;
  const double codes = std::exp2(line.bits - 1), step = line.reach / codes;
  return step * std::clamp(std::nearbyint(value / step), -codes, codes - 1);
}

void ReadingFaults::pass_on(int station, std::span<double> values, std::mt19937_64& random) {
  const auto happens = [&](double probability) {
    return probability > 0.0 && std::uniform_real_distribution<double>(0.0, 1.0)(random) < probability;
  };
  std::vector<double>& before = passed_on_[station];
  const bool repeat = happens(repeats_) && !before.empty(), zero = happens(zeros_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (repeat || (happens(lines_[i].repeats) && !before.empty())) values[i] = before[i];
    if (zero || happens(lines_[i].zeros)) values[i] = 0.0;
  }
  before.assign(values.begin(), values.end());
}

double ReadingFaults::sampled_at(int station) const {
  const auto of = station_sampled_at_.find(station);
  return of == station_sampled_at_.end() ? sampled_at_ : of->second;
}

}  // namespace rigsim
