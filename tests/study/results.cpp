#include "tests/study/results.hpp"

#include <algorithm>

#include "tests/study/figures.hpp"

namespace dwell::study {
namespace {

bool is_healthy(Population population) {
  return population == Population::white || population == Population::tracked || population == Population::type_b ||
         population == Population::quantized;
}

void append(std::vector<Row>& rows, std::vector<Row> more) {
  for (Row& row : more) rows.push_back(std::move(row));
}

}  // namespace

std::vector<Outcome> Results::of(const std::vector<Population>& populations) const {
  std::vector<Outcome> all;
  for (const auto& [population, outcomes] : begun)
    if (std::count(populations.begin(), populations.end(), population) > 0)
      all.insert(all.end(), outcomes.begin(), outcomes.end());
  return all;
}

std::vector<Outcome> Results::all_begun() const {
  std::vector<Population> populations;
  for (const auto& [population, outcomes] : begun)
    if (population != Population::stiff && population != Population::resonance && population != Population::knocks)
      populations.push_back(population);
  return of(populations);
}

std::vector<Row> rows_of(const Results& results, double slack) {
  std::vector<Row> rows;
  long rearmed = 0;
  std::vector<Population> healthy;
  for (const auto& [population, outcomes] : results.begun) {
    for (const Outcome& outcome : outcomes) rearmed += outcome.rearmed;
    if (is_healthy(population)) healthy.push_back(population);
    if (population == Population::stiff) continue;
    if (population == Population::white || population == Population::tracked) {
      const bool tracked = population == Population::tracked;
      rows.push_back(bound_row(outcomes, tracked ? 1.10 : 1.05, slack));
      rows.back().figure = tracked ? "rms error over the Cramér-Rao bound, frequency tracked from 1 % off"
                                   : "rms error over the Cramér-Rao bound, frequency given";
    }
    if (population != Population::tracked) rows.push_back(coverage_row(outcomes, population, slack));
    if (population == Population::knocks) rows.push_back(late_row(outcomes, population, slack));
    if (population == Population::resonance || population == Population::knocks)
      rows.push_back(early_row(outcomes, population, slack));
  }
  for (const auto& [population, outcomes] : results.steps) {
    rows.push_back(step_row(outcomes, population, slack));
    for (const StepOutcome& outcome : outcomes) rearmed += outcome.disturbed;
  }
  if (!results.hours.empty()) rows.push_back(hours_row(results.hours, rearmed, slack));
  if (!results.ramps.empty()) rows.push_back(ramps_row(results.ramps, slack));
  if (!results.disturbed.empty()) append(rows, disturbed_rows(results.disturbed, slack));
  if (const std::vector<Outcome> begun = results.all_begun(); !begun.empty()) append(rows, settling_rows(begun, slack));
  if (!healthy.empty()) append(rows, blamed_rows(results.of(healthy), slack));
  const std::vector<Outcome> judged = results.of({Population::white, Population::tracked, Population::stiff});
  if (!judged.empty()) append(rows, reported_rows(judged, slack));
  return rows;
}

}  // namespace dwell::study
