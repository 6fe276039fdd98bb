// What the likelihood of a motion is a function of: the coefficients, what nothing states (the intensity of the table's
// motion, the noise of each channel), what the rig file states with an uncertainty, and what it may lack.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

enum class Unknown : std::uint8_t {
  stiffness,         // c of element `index` + 1, N/m
  damping,           // r of element `index` + 1, N·s/m
  intensity,         // ln q of the table's motion in stretch `index`; q in m²/s, see MotionModel
  noise,             // ln σ of channel `index`, σ in SI
  drive,             // relative departure of the table's own frequency from the nominal drive
  mass,              // departures from what is stated: of mass `index` + 1, kg
  scale,             // relative, of channel `index`: it shows that part more
  delay,             // s, of channel `index`
  device_delay,      // s, of device `index`
  lowpass,           // Hz, of the corner of channel `index`
  highpass,          // likewise
  clock,             // relative: true time runs faster than the stamps by this part
  ground_stiffness,  // of a spring from mass `index` + 1 to ground, N/m
  ground_damping,    // of a damper there, N·s/m
  side_stiffness,    // of a spring between the pair of places apart()[`index`], N/m
  friction,          // Coulomb's, in element `index` + 1, N
  ground_friction,   // Coulomb's, between mass `index` + 1 and ground, N
  cubic,             // force of that element per cube of its deformation, N/m³
};

struct Parameter {
  Unknown what = Unknown::stiffness;
  int index = 0;
  double prior_u = 0.0;  // standard deviation of the prior, mean 0; 0: none
};

// The forces of these are known functions of the motion: in the model they stand as inputs of unknown amplitude
// (MotionInput of core/motion/likelihood.hpp).
[[nodiscard]] constexpr bool is_input(Unknown what) noexcept {
  return what == Unknown::friction || what == Unknown::ground_friction || what == Unknown::cubic;
}

// Pairs of places that no element joins: 0 the table, k mass k, the nearer to the table first. A rig file may lack a
// spring between them. With more than eight masses only the pairs that have one mass between them: masses - 1 pairs.
[[nodiscard]] std::vector<std::pair<int, int>> apart(int masses);

// Two places in words: "between the table and mass 2", "between mass 1 and mass 4".
[[nodiscard]] std::string between(const std::pair<int, int>& places);

// Coefficients, intensities of `stretches` stretches, noise of all channels that count, without priors; then the drive.
[[nodiscard]] std::vector<Parameter> free_parameters(const Rig& rig, int stretches);
// What the rig file states with a standard uncertainty above 0.
[[nodiscard]] std::vector<Parameter> stated_parameters(const Rig& rig);

// As the budget of a dwell names its source: "scale of y1", "mass 2", "delay of amplifier", "noise of y0".
[[nodiscard]] std::string name_of(const Rig& rig, const Parameter& parameter);

// The entry of a budget for one of stated_parameters(): name, kind, and whose it is. Its shares are 0.
[[nodiscard]] BudgetShare source_of(const Rig& rig, const Parameter& stated);

}  // namespace dwell
