// What all dwells of a run of the study came to, the table made of it, and the file that keeps it.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "tests/study/disturbed.hpp"
#include "tests/study/outcome.hpp"
#include "tests/study/table.hpp"

namespace dwell::study {

struct Results {
  std::uint64_t seed = 1;
  std::map<Population, std::vector<Outcome>> begun;  // of populations that settle and are measured
  std::map<Population, std::vector<StepOutcome>> steps;
  std::vector<HoursOutcome> hours;
  std::vector<RampsOutcome> ramps;
  std::vector<DisturbedOutcome> disturbed;

  // Dwells of `populations` together.
  [[nodiscard]] std::vector<Outcome> of(const std::vector<Population>& populations) const;
  // Every population that begins with a transient, but for resonance and knocks, which have rows of their own.
  [[nodiscard]] std::vector<Outcome> all_begun() const;
};

// The table; slack as in figures.hpp. Rows of populations that were not played are left out.
[[nodiscard]] std::vector<Row> rows_of(const Results& results, double slack);

// One line per dwell: population, index, then each figure's name and value. The first line holds the seed.
void write(std::ostream& out, const Results& results);
// What is wrong with the file, with its line; or empty.
[[nodiscard]] std::string read(std::istream& in, Results& results);

// Each row's figure in both, the difference and its 95 % interval by a paired bootstrap: the same dwells are drawn from
// both, kRedraws times, population by population. Only dwells that are in both count. worse: set where a row's figure
// is worse beyond doubt. What is wrong, or empty.
[[nodiscard]] std::string compare(const Results& before, const Results& after, std::vector<std::string>& lines,
                                  bool& worse);

}  // namespace dwell::study
