// One fault of a rig that its file does not know of, and how far it stands out: its size over its own standard
// uncertainty where everything else that is unknown is estimated beside it (the Cramér-Rao bound of the model that has
// that one parameter more). White noise, a drive that begins at 0.
#pragma once

#include <cstdint>
#include <string>

#include "tests/study/case.hpp"

namespace dwell::study {

enum class Fault : std::uint8_t { mass, scale, delay, cubic, friction, ground_damper, ground_spring };
inline constexpr int kFaults = 7;
[[nodiscard]] const char* name_of(Fault fault);

// Puts one of drawn size and place into the case. Friction and cubic springs: the case must begin from rest. Returns
// how far it stands out in the readings up to what will be measured; 0: no reading tells of it.
double put_fault(Fault fault, Draws& draws, Case& about);

}  // namespace dwell::study
