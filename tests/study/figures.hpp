// From outcomes to rows of the table.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/study/outcome.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {

// That part of the values is at most it; NaN of none.
[[nodiscard]] double quantile(std::vector<double> values, double part);
// Lateness over the larger of so many periods and time constants; ∞: never settled.
[[nodiscard]] double late_by(const Outcome& outcome, double periods, double taus);
// Whether the element's error is held against its bound: at least 50 periods counted, the bound below |Z|/10.
[[nodiscard]] bool counts_for_bound(const Outcome& outcome, const ElementOutcome& element);

// slack: 0, or 1 in the short form, where few dwells stand behind a figure and the bounds are wider.
[[nodiscard]] Row bound_row(const std::vector<Outcome>& outcomes, double target, double slack);
[[nodiscard]] Row coverage_row(const std::vector<Outcome>& outcomes, Population population, double slack);
// Too early, and late by the median and the 95th percentile.
[[nodiscard]] std::vector<Row> settling_rows(const std::vector<Outcome>& outcomes, double slack);
// Too early, of one population; how late beside it.
[[nodiscard]] Row early_row(const std::vector<Outcome>& outcomes, Population population, double slack);
// Late by the 95th percentile, of one population.
[[nodiscard]] Row late_row(const std::vector<Outcome>& outcomes, Population population, double slack);
// An element that must not be reported, and that must be.
[[nodiscard]] std::vector<Row> reported_rows(const std::vector<Outcome>& outcomes, double slack);
// Healthy dwells in which a channel, an element or the drive is blamed for a disturbance; and those that withhold an
// element because its coefficient may be negative by chance.
[[nodiscard]] std::vector<Row> blamed_rows(const std::vector<Outcome>& outcomes, double slack);
// Every step seen in time.
[[nodiscard]] Row step_row(const std::vector<StepOutcome>& outcomes, Population population, double slack);
// others: false re-arms elsewhere in the study.
[[nodiscard]] Row hours_row(const std::vector<HoursOutcome>& outcomes, long others, double slack);
[[nodiscard]] Row ramps_row(const std::vector<RampsOutcome>& outcomes, double slack);
// Errors and time to answer of the service and of the script on the same recordings, as lines of text.
[[nodiscard]] std::vector<std::string> beside(const std::vector<Outcome>& outcomes);
// The figures of one population by kind of rig, and the dwells that did worst by each, as lines.
[[nodiscard]] std::vector<std::string> worst(const std::vector<Outcome>& outcomes, Population population,
                                             std::uint64_t seed);

}  // namespace dwell::study
