// Columns of coefficients in a table: value ± U95, and where it is known the truth of a simulated rig beside it.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "daemon/report/table.hpp"

namespace dwell {

// "24.010 ± 0.027 kN/m" for each element, aligned; what is not significant is marked " n.s.".
[[nodiscard]] std::vector<std::string> coefficient_cells(const std::vector<ElementEstimate>& elements,
                                                         Coefficient ElementEstimate::*which, const char* unit);

// Two columns: the true value, and by how many standard uncertainties the coefficient is off. truth: SI, one per
// element.
void add_truth(Table& table, const std::vector<ElementEstimate>& elements, Coefficient ElementEstimate::*which,
               const std::vector<double>& truth, const char* unit);

}  // namespace dwell
