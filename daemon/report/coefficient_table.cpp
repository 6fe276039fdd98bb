#include "daemon/report/coefficient_table.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "daemon/report/number_text.hpp"

namespace dwell {

std::vector<std::string> coefficient_cells(const std::vector<ElementEstimate>& elements,
                                           Coefficient ElementEstimate::*which, const char* unit) {
  std::vector<NumberText> numbers;
  numbers.reserve(elements.size());
  for (const ElementEstimate& e : elements)
    numbers.push_back(e.identifiable ? number_text((e.*which).value, (e.*which).U95, unit)
                                     : NumberText{kNoNumber, "", ""});
  std::vector<std::string> cells = join_aligned(numbers);
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (elements[i].identifiable && !(elements[i].*which).significant) cells[i] += " n.s.";
  return cells;
}

void add_truth(Table& table, const std::vector<ElementEstimate>& elements, Coefficient ElementEstimate::*which,
               const std::vector<double>& truth, const char* unit) {
  std::vector<NumberText> values;
  std::vector<std::string> deviations;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const double value = i < truth.size() ? truth[i] : kNaN;
    const Coefficient& c = elements[i].*which;
    const double deviation = elements[i].identifiable ? (c.value - value) / c.u : kNaN;
    values.push_back(number_text(value, unit, 6));
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%+.1f u", deviation);
    deviations.emplace_back(std::isfinite(deviation) ? text.data() : kNoNumber);
  }
  table.add("true", join_aligned(values), Align::left, true);
  table.add("off by", std::move(deviations), Align::right, true);
}

}  // namespace dwell
