// A chain of masses and elements with its coefficients (docs/method.md, Symbols). Element k joins mass k-1 to mass k.
// Mass 0 is the table, whose motion is imposed. Plain data: identification fills it, the forward model reads it.
#pragma once

#include <string>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell {

struct Chain {
  Boundary boundary = Boundary::free;
  std::vector<double> masses;     // m_1 … m_n, kg (kg·m²); n ≥ 1 free, n ≥ 0 clamped
  std::vector<double> stiffness;  // c_1 …, one per element, N/m (N·m/rad)
  std::vector<double> damping;    // r_1 …, one per element, N·s/m (N·m·s/rad)

  [[nodiscard]] int mass_count() const noexcept { return static_cast<int>(masses.size()); }
  // n for a free chain, n + 1 for a clamped one.
  [[nodiscard]] int element_count() const noexcept { return mass_count() + (boundary == Boundary::clamped ? 1 : 0); }

  // Names the first fault ("masses[1] is -3: expected a positive number"); empty for a valid chain.
  // Coefficients must be finite. They may be zero or negative, as an estimate can be.
  [[nodiscard]] std::string fault() const;
};

}  // namespace dwell
