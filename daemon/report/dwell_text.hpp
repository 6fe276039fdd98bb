// A dwell as an operator reads it, what matters most first: the reasons not to rely on its numbers, the coefficients
// with what their ± leaves out, the verdicts on their limits, the warnings; then settling and frequency, a table of
// channels, and where the terminal is narrow the columns that found no room. Intervals are 95 %.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "daemon/report/dwell_view.hpp"
#include "daemon/report/line.hpp"

namespace dwell {

// What a simulated rig really is; one value per element, SI.
struct Truth {
  std::vector<double> stiffness;
  std::vector<double> damping;
};

// What is known of a channel beside its phasor.
struct ChannelNote {
  std::string age;     // "12 s": its numbers are so old; empty: they are not
  std::string status;  // how it stands now where that is not well: "clipped: …"; empty: well, or not known
};

struct TextOptions {
  std::size_t columns = kUnlimited;  // no line is longer than that, as far as tables can be broken
  const Truth* truth = nullptr;      // shown beside the measured, with the deviation in standard uncertainties
  std::string age;      // "778 s": the whole dwell is so old; its numbers are marked with it. Empty: it is not
  bool result = false;  // the dwell has ended: with an age its numbers are a result, its verdicts hold
  std::vector<ChannelNote> channels;  // one per channel, or none
  bool frequency = true;              // false: it stands elsewhere, see frequency_text()
  bool legend = true;                 // false: it stands elsewhere, see legend_of()
};

// Of numbers that have an age.
[[nodiscard]] inline Style aged(const TextOptions& options) noexcept {
  return options.result ? Style::past : Style::old;
}

// Marks that stand behind the text of a coefficient: " n.s." not significant, " ?" not to be relied on.
[[nodiscard]] std::string marks(const Dwell& dwell, const ElementEstimate& element, const Coefficient& coefficient);

// "do not rely on elements 1, 3: why".
[[nodiscard]] std::string doubt_text(const Doubt& doubt);

// What ± means here, what the marks mean that occur, and which uncertainties no ± covers, for below a table of these
// dwells; empty: no coefficient stands in it.
[[nodiscard]] std::vector<std::string> legend_of(const std::vector<const Dwell*>& dwells);

// "± covers only noise, clock and what the rig file states; not stated: …"; empty: all is stated.
[[nodiscard]] std::string unstated_text(const std::vector<std::string>& unstated);

// One line without its end: "dwell 3 · measuring, 24.6 s of data".
[[nodiscard]] std::string headline(const DwellView& view);

// "4.000300 ± 0.000039 Hz"; "4.000 Hz so far" before the dwell has settled; empty: not known.
[[nodiscard]] std::string frequency_text(const Dwell& dwell);

// Names of sections.
inline constexpr std::string_view kDoubts = "doubts";
inline constexpr std::string_view kCoefficients = "coefficients";
inline constexpr std::string_view kWarnings = "warnings";

// Everything but the headline, in the order stated above; no section is empty. `age` stands as a column in both tables
// where something is old. Phases are relative to the first channel that has one, which the column's title names.
[[nodiscard]] std::vector<Section> dwell_sections(const DwellView& view, const TextOptions& options = {});

// All of it as text, lines as long as they come.
[[nodiscard]] std::string dwell_text(const DwellView& view, const Truth* truth = nullptr);

}  // namespace dwell
