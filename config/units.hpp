// Units: what a channel may be given in, the factor to SI, and the labels under which results are reported.
//
// The factors are exact by definition (inch 0.0254 m, pound-force 4.4482216152605 N, g 9.80665 m/s²); of angles they
// are as exact as π is in a double. All functions are pure and thread-safe.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/rig/rig.hpp"

namespace dwell::config {

struct Unit {
  std::string_view name;
  double si_per_unit;
};

// All units of a quantity (force of a rotation rig: torque), the SI unit first. Auxiliary: none, for its unit is free.
[[nodiscard]] std::vector<Unit> units_of(Quantity quantity, Motion motion);

// SI per unit; none: not a unit of that quantity.
[[nodiscard]] std::optional<double> si_per_unit(Quantity quantity, Motion motion, std::string_view unit);

// "m, mm, um, in, …", for messages.
[[nodiscard]] std::string unit_names(Quantity quantity, Motion motion);

// Labels of what is reported, SI: "m", "m/s", "m/s2", "N" or "rad", "rad/s", "rad/s2", "N*m"; auxiliary: "".
[[nodiscard]] const char* si_unit(Quantity quantity, Motion motion) noexcept;
[[nodiscard]] const char* stiffness_unit(Motion motion) noexcept;  // "N/m" or "N*m/rad"
[[nodiscard]] const char* damping_unit(Motion motion) noexcept;    // "N*s/m" or "N*m*s/rad"
[[nodiscard]] const char* mass_unit(Motion motion) noexcept;       // "kg" or "kg*m2"

// The words of the rig file: "displacement", … and "translation", ….
[[nodiscard]] const char* to_string(Quantity quantity) noexcept;
[[nodiscard]] const char* to_string(Motion motion) noexcept;

}  // namespace dwell::config
