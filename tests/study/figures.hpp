// From outcomes to rows of the table.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/study/outcome.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {

// slack: 0, or how much wider the bounds are in the short form, where few dwells stand behind a figure.
[[nodiscard]] Row bound_row(const std::vector<Outcome>& outcomes, double target, double slack);
[[nodiscard]] Row coverage_row(const std::vector<Outcome>& outcomes, Population population, double slack);
// Too early, and late by the median and the 95th percentile.
[[nodiscard]] std::vector<Row> settling_rows(const std::vector<Outcome>& outcomes, double slack);
// An element that must not be reported, and that must be.
[[nodiscard]] std::vector<Row> reported_rows(const std::vector<Outcome>& outcomes, double slack);
// Every step seen in time.
[[nodiscard]] Row step_row(const std::vector<StepOutcome>& outcomes, Population population);
[[nodiscard]] Row hours_row(const std::vector<HoursOutcome>& outcomes);
[[nodiscard]] Row ramps_row(const std::vector<RampsOutcome>& outcomes, double slack);
// Errors and time to answer of the service and of the script on the same recordings, as lines of text.
[[nodiscard]] std::vector<std::string> beside(const std::vector<Outcome>& outcomes);
// The dwells of one population that did worst by each figure, as lines.
[[nodiscard]] std::vector<std::string> worst(const std::vector<Outcome>& outcomes, Population population,
                                             std::uint64_t seed);

}  // namespace dwell::study
