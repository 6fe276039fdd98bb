#include "tests/rigsim/reading_faults.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/rigsim/device.hpp"
#include "tests/rigsim/stations.hpp"

namespace rigsim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSlowest_s = 3600.0;
constexpr double kMostReach = 1e6;
constexpr double kMostLag_s = 1.0;  // a chain that is integrated remembers 2 s (BentChain)

std::optional<int> station_number(const std::string& word) {
  const auto value = number(word);
  if (!value || *value < 1 || *value > kStations || *value != std::floor(*value)) return std::nullopt;
  return static_cast<int>(*value);
}

// What a float32 gives where its words are read in the wrong order.
double other_words(double value) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return std::bit_cast<float>(bits << 16 | bits >> 16);
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
  if (auto answer = set_gateway(words)) return answer;
  return set_transducer(words);
}

std::vector<ReadingFaults::Line*> ReadingFaults::meant(const std::string& target) {
  std::vector<Line*> lines;
  const auto channel = find(target);
  for (std::size_t i = 0; i < lines_.size(); ++i)
    if (target == "all" || channel == i) lines.push_back(&lines_[i]);
  return lines;
}

std::optional<std::string> ReadingFaults::set_gateway(const std::vector<std::string>& words) {
  const std::string& verb = words[0];
  const bool freeze = verb == "freeze", stale = verb == "stale";
  if (!freeze && !stale && verb != "garbage") return std::nullopt;
  constexpr double kNone = -1.0;
  const double value = words.size() < 3 ? kNone : within(words[2], 0.0, stale ? 1e6 : 1.0).value_or(kNone);
  const double seconds = words.size() < 4 ? kNone : within(words[3], 0.0, kSlowest_s).value_or(kNone);
  if (value < 0 || words.size() != (freeze ? 4U : 3U) || (freeze && seconds < 0) ||
      (stale && (value == 1 || value != std::floor(value))))
    return freeze  ? "expected: freeze all|CHANNEL P S, P 0 to 1, at most 3600 s"
           : stale ? "expected: stale all|CHANNEL N, 2 or more readings (0: none)"
                   : "expected: garbage all|CHANNEL P, 0 to 1";
  const std::vector<Line*> lines = meant(words[1]);
  for (Line* line : lines) {
    if (stale) line->stale = static_cast<int>(value);
    if (freeze) line->freeze = value, line->freeze_s = seconds;
    if (verb == "garbage") line->garbage = value;
  }
  return lines.empty() ? "no channel " + words[1] : std::string();
}

std::optional<std::string> ReadingFaults::set_transducer(const std::vector<std::string>& words) {
  const std::string& verb = words[0];
  if (verb != "low-byte" && verb != "glitch" && verb != "scale" && verb != "lag" && verb != "swap") return std::nullopt;
  if (words.size() < 3) return "expected: " + verb + " CHANNEL and a value";
  const std::size_t channel = find(words[1]).value_or(lines_.size());
  if (channel == lines_.size()) return "no channel " + words[1];
  Line& line = lines_[channel];
  const auto of = [&](double low, double high) {
    return words.size() == 3 ? within(words[2], low, high) : std::nullopt;
  };
  if (verb == "swap") {
    const auto with = words.size() == 3 ? find(words[2]) : std::nullopt;
    if (!with || *with == channel) return "expected: swap CHANNEL CHANNEL, two different ones";
    swapped_.emplace_back(channel, *with);
  } else if (verb == "scale") {
    const auto factor = within(words[2], -kMostReach, kMostReach);
    const auto part = words.size() == 4 ? within(words[3], 0.0, 1.0) : std::optional(1.0);
    if (!factor || *factor == 0 || words.size() > 4 || !part)
      return "expected: scale CHANNEL FACTOR [P], not 0 (-1: reversed), P 0 to 1";
    line.scale = *factor;
    line.scale_part = *part;
  } else if (verb == "lag") {
    const auto seconds = within(words[2], 0.0, kMostLag_s);
    const auto spread = words.size() == 4 ? within(words[3], 0.0, kMostLag_s) : std::optional(0.0);
    if (!seconds || words.size() > 4 || !spread || *seconds + *spread > kMostLag_s)
      return "expected: lag CHANNEL S [SPREAD], together 0 to 1";
    line.lag_s = *seconds;
    line.lag_spread_s = *spread;
  } else if (verb == "low-byte") {
    const auto code = of(-1, 255);
    if (!code || *code != std::floor(*code)) return "expected: low-byte CHANNEL CODE, 0 to 255 (-1: as it converts)";
    line.low_byte = static_cast<int>(*code);
  } else {
    const auto size = within(words[2], -kMostReach, kMostReach);
    const auto part = words.size() == 4 ? within(words[3], 0.0, 1.0) : std::nullopt;
    if (!size || words.size() > 4 || (words.size() == 4 && !part))
      return "expected: glitch CHANNEL X [P], in steady amplitudes, P 0 to 1";
    line.glitch = *size * full_[channel];
    line.glitch_once = !part;
    line.glitch_part = part.value_or(0.0);
  }
  return std::string();
}

std::optional<double> ReadingFaults::taken_at(std::size_t channel, int station, double t_s) const {
  double refresh_s = refresh_s_;
  if (const auto of = station_refresh_s_.find(station); of != station_refresh_s_.end()) refresh_s = of->second;
  if (lines_[channel].refresh_s > 0) refresh_s = lines_[channel].refresh_s;
  if (!(refresh_s > 0)) return std::nullopt;
  return refresh_s * std::floor(t_s / refresh_s);
}

double ReadingFaults::lag_s(std::size_t channel, std::mt19937_64& random) const {
  const Line& line = lines_[channel];
  if (!(line.lag_spread_s > 0)) return line.lag_s;
  return line.lag_s + std::uniform_real_distribution<double>(0.0, line.lag_spread_s)(random);
}

double ReadingFaults::converted(std::size_t channel, double value, std::mt19937_64& random) const {
  const Line& line = lines_[channel];
  const bool scaled = line.scale_part == 1.0 || std::bernoulli_distribution(line.scale_part)(random);
  value = std::clamp((scaled ? line.scale : 1.0) * value, line.low, line.high);
  if (line.bits == 0 || !(line.reach > 0)) return value;
  const double codes = std::exp2(line.bits - 1), step = line.reach / codes;
  double code = std::clamp(std::nearbyint(value / step), -codes, codes - 1);
  if (line.low_byte >= 0) code = 256 * std::floor(code / 256) + line.low_byte;
  return step * code;
}

double ReadingFaults::glitch(std::size_t channel, std::mt19937_64& random) {
  Line& line = lines_[channel];
  if (std::exchange(line.glitch_once, false)) return line.glitch;
  return line.glitch_part > 0 && std::bernoulli_distribution(line.glitch_part)(random) ? line.glitch : 0.0;
}

void ReadingFaults::pass_on(double t_s, int station, std::span<double> values, std::mt19937_64& random) {
  const auto happens = [&](double probability) {
    return probability > 0.0 && std::uniform_real_distribution<double>(0.0, 1.0)(random) < probability;
  };
  std::vector<PassedOn>& passed = passed_on_[station];
  passed.resize(values.size());
  for (const auto& [a, b] : swapped_) std::swap(values[a], values[b]);
  const bool repeat = happens(repeats_), zero = happens(zeros_);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const Line& line = lines_[i];
    PassedOn& before = passed[i];
    if (t_s >= before.frozen_until_s && happens(line.freeze)) before.frozen_until_s = t_s + line.freeze_s;
    const bool stale = line.stale > 0 && before.readings % line.stale == line.stale - 1;
    const bool again = repeat || happens(line.repeats) || stale || t_s < before.frozen_until_s;
    if (happens(line.garbage)) values[i] = other_words(values[i]);
    if (again && before.any) values[i] = before.value;
    if (zero || happens(line.zeros)) values[i] = 0.0;
    before.value = values[i];
    before.any = true;
    ++before.readings;
  }
}

double ReadingFaults::sampled_at(int station) const {
  const auto of = station_sampled_at_.find(station);
  return of == station_sampled_at_.end() ? sampled_at_ : of->second;
}

}  // namespace rigsim
