#include "core/model/chain.hpp"

#include <cmath>

namespace dwell {
namespace {

std::string count_fault(const char* name, std::size_t found, int expected) {
  return std::string(name) + " has " + std::to_string(found) + " values: expected one per element, " +
         std::to_string(expected);
}

}  // namespace

std::string Chain::fault() const {
  if (element_count() == 0) return "masses: expected at least one for a free chain, found none";
  for (std::size_t i = 0; i < masses.size(); ++i)
    if (!(masses[i] > 0.0) || !std::isfinite(masses[i]))
      return "masses[" + std::to_string(i) + "] is " + std::to_string(masses[i]) + ": expected a positive number";
  const auto elements = static_cast<std::size_t>(element_count());
  if (stiffness.size() != elements) return count_fault("stiffness", stiffness.size(), element_count());
  if (damping.size() != elements) return count_fault("damping", damping.size(), element_count());
  for (std::size_t i = 0; i < elements; ++i) {
    if (!std::isfinite(stiffness[i])) return "stiffness[" + std::to_string(i) + "] is not finite";
    if (!std::isfinite(damping[i])) return "damping[" + std::to_string(i) + "] is not finite";
  }
  return {};
}

}  // namespace dwell
