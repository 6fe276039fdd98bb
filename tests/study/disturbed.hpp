// One dwell of the population `disturbed`, played and judged; and the table of all of them, kind by kind.
#pragma once

#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "tests/study/moved.hpp"
#include "tests/study/outcome.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {

// An error beyond so many stated standard uncertainties is a wrong number.
inline constexpr double kWrong = 5.0;

struct DisturbedOutcome {
  int index = 0;
  std::vector<Kind> kinds;
  bool counts = true;         // the fault is one that must be seen (Moved::shows)
  bool covered = false;       // … but the coefficients' own uncertainty covers what it does to the poles
  bool harmless = false;      // Moved::harmless
  bool settled = false;       // a dwell was completed that has coefficients
  bool reported = false;      // … with every element that stands out
  bool trusted = false;       // … and no doubt about it
  bool warned = false;        // a warning names the cause and a channel or an element concerned
  double worst = 0.0;         // largest error over its stated u, of all coefficients of all dwells
  double worst_silent = 0.0;  // … of the dwells without such a warning
  bool doubted = false;       // what is worst_silent carries a doubt, of another cause
  bool told_beside = false;   // what is worst_silent is named by the method of any motion beside the dwell
  bool told_live = false;     // … is named by what the service says beside the live dwell
  double moved = 0.0;         // largest shift of a coefficient that stands out, over its u
  // It shows a coefficient that is wrong, and nothing says why.
  [[nodiscard]] bool silent() const { return counts && worst_silent > kWrong; }
  // … and the method of any motion does not say it either.
  [[nodiscard]] bool silent_throughout() const { return silent() && !told_beside; }
  // … and what the service says beside the live dwell does not say it either.
  [[nodiscard]] bool silent_live() const { return silent() && !told_live; }
};

[[nodiscard]] DisturbedOutcome play_disturbed(const Case& about, const Trace& trace = {});

// All that a dwell tells of its numbers: warnings and doubts.
[[nodiscard]] std::vector<std::string> told_by(const Dwell& dwell);
// Whether a line names the cause, and a channel or an element that the disturbance concerns, or the drive where the
// drive is at fault. Where the model is, a mass, an element or the chain will do: which of mass, spring and
// transducer is to blame, no steady motion tells.
[[nodiscard]] bool names(const Case& about, const Disturbance& disturbance, const std::string& line);
// Hum and folded harmonics, which nobody can see, blame nothing.
[[nodiscard]] bool blameless(const Warning& warning);
// Whether a line of a healthy dwell blames a channel, an element or the drive for any of the kinds.
[[nodiscard]] bool blames(const Case& about, const std::string& line);

[[nodiscard]] std::vector<Row> disturbed_rows(const std::vector<DisturbedOutcome>& outcomes, double slack);
// Kind by kind.
[[nodiscard]] std::vector<std::string> disturbed_table(const std::vector<DisturbedOutcome>& outcomes);
[[nodiscard]] std::vector<std::string> disturbed_worst(const std::vector<DisturbedOutcome>& outcomes,
                                                       std::uint64_t seed);

}  // namespace dwell::study
