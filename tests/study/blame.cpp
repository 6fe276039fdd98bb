// What a message must say to name a disturbance.
#include <algorithm>
#include <cctype>
#include <string_view>

#include "tests/study/disturbed.hpp"

namespace dwell::study {
namespace {

using Words = std::vector<std::string_view>;

const Words& cause_words(Kind kind) {
  static const Words stale = {"refresh",    "repeat",  "identical", "stale",     "held",  "holds still", "same reading",
                              "same value", "updates", "updated",   "new value", "stuck", "stands still"};
  static const Words clip = {"clip",         "overrange",    "beyond its range", "extreme",
                             "pile",         "saturat",      "end code",         "end of its range",
                             "limit of its", "largest code", "smallest code",    "lowest code"};
  static const Words cluster = {"zero",  "cluster", "second group", "far from",
                                "spike", "outlier", "invalid",      "no value"};
  static const Words grid = {"far from", "spike", "outlier", "round", "grid", "coarse", "resolution"};
  static const Words steps = {"round", "grid", "coarse", "low byte", "step of", "steps of", "resolution"};
  static const Words fold = {"fold", "alias"};
  static const Words instants = {"turnaround", "transaction", "station", "instant", "delay", " late"};
  static const Words frequency = {"drive is at"};
  static const Words amplitude = {"amplitude", "not steady", "wander", "hunt", "swing", "drift", "modulat"};
  static const Words bent = {"linear", "friction", "equivalent", "cubic"};
  static const Words model = {"contradict", "natural", "mode",   "pole",     "eigenvalue", "decay", "negative",
                              "passive",    "model",   "masses", "disagree", "transient",  "signs", "explain"};
  switch (kind) {
    case Kind::refresh_one:
    case Kind::refresh_all:
    case Kind::repeats_one:
    case Kind::repeats_all:
    case Kind::bursts:
    case Kind::alternate:
      return stale;
    case Kind::clip_both:
    case Kind::clip_one:
      return clip;
    case Kind::end_codes: {
      static const Words both = [] {
        Words words = clip;
        words.insert(words.end(), cluster.begin(), cluster.end());
        return words;
      }();
      return both;
    }
    case Kind::zeros_one:
    case Kind::zeros_all:
      return cluster;
    case Kind::glitch_rounded:
      return grid;
    case Kind::low_byte:
      return steps;
    case Kind::folded:
      return fold;
    case Kind::stations:
      return instants;
    case Kind::fixed_off:
      return frequency;
    case Kind::hunting:
    case Kind::hunting_short:
    case Kind::drift:
      return amplitude;
    case Kind::friction:
    case Kind::cubic:
      return bent;
    default:
      return model;
  }
}

bool has(const std::string& line, std::string_view part) { return line.find(part) != std::string::npos; }

// The name as a word of its own: "y1" is not in "y10".
bool has_word(const std::string& line, const std::string& word) {
  const auto part_of_word = [&](std::size_t at) {
    return at < line.size() && (std::isalnum(static_cast<unsigned char>(line[at])) != 0 || line[at] == '_');
  };
  for (std::size_t at = line.find(word); at != std::string::npos; at = line.find(word, at + 1))
    if ((at == 0 || !part_of_word(at - 1)) && !part_of_word(at + word.size())) return true;
  return false;
}

std::string lowered(std::string line) {
  std::transform(line.begin(), line.end(), line.begin(), [](unsigned char c) { return std::tolower(c); });
  return line;
}

bool is_of_drive(Kind kind) {
  return kind == Kind::fixed_off || kind == Kind::hunting || kind == Kind::hunting_short || kind == Kind::drift;
}

bool says(Kind kind, const std::string& line) {
  const Words& words = cause_words(kind);
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) { return has(line, word); });
}

// Whether the line blames the chain, as the method of any motion does. It names a channel that shows it, or a term that
// explains it.
bool blames_chain(const std::string& line) {
  return has(line, "chain of the rig file does not explain") || has(line, "no linear chain explains") ||
         has(line, "better explained with");
}

}  // namespace

bool blameless(const Warning& warning) {
  return warning.kind == WarningKind::hum || warning.kind == WarningKind::folded_harmonic;
}

std::vector<std::string> told_by(const Dwell& dwell) {
  std::vector<std::string> lines;
  for (const Warning& warning : dwell.warnings) lines.push_back(warning.what);
  for (const Doubt& doubt : dwell.doubts) lines.push_back(doubt.what);
  return lines;
}

bool names(const Case& about, const Disturbance& disturbance, const std::string& said) {
  const std::string line = lowered(said);
  if (!says(disturbance.kind, line)) return false;
  for (const int c : disturbance.channels)
    if (has_word(line, about.rig.channels[static_cast<std::size_t>(c)].name)) return true;
  // That an element is not linear at some amplitude says nothing of the drive.
  for (const int k : disturbance.elements)
    if (!is_of_drive(disturbance.kind) && has_word(line, "element " + std::to_string(k))) return true;
  if (is_of_drive(disturbance.kind) && (has_word(line, "drive") || has_word(line, "table"))) return true;
  return is_of_model(disturbance.kind) && (has_word(line, "elements") || blames_chain(line));
}

bool blames(const Case& about, const std::string& said) {
  const std::string line = lowered(said);
  bool named = has_word(line, "drive") || has_word(line, "table") || has(line, "element");
  for (const Channel& channel : about.rig.channels) named = named || has_word(line, channel.name);
  if (!named) return false;
  for (int kind = 0; kind < kKinds; ++kind)
    if (says(static_cast<Kind>(kind), line)) return true;
  return false;
}

}  // namespace dwell::study
