// The chain of masses as the method writes it (docs/method.md, Symbols): element k joins mass k-1 to mass k, mass 0
// being the table, whose motion is imposed. Plain data; the forward model reads it, identification fills it.
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
  // n free, n + 1 clamped.
  [[nodiscard]] int element_count() const noexcept { return mass_count() + (boundary == Boundary::clamped ? 1 : 0); }

  // Why this is not a chain that can be solved ("masses[1] is -3: expected a positive number"), or empty. Coefficients
  // may be zero or negative (an estimate can be), but must be finite.
  [[nodiscard]] std::string fault() const;
};

}  // namespace dwell
