// The simulated transducers as CAN messages: what is sent, and the DBC file that says so.
//
// One message a channel. Even masses (the table is 0): `Motion<k>`, identifier 0x200 + k, a signed Intel integer of 1
// nm. Odd ones: a Motorola float in mm, behind a selector (multiplexed; value 0). The ground force: `LoadCell`, a J1939
// message of the group 65360 (proprietary), an Intel float in N. Every message ends with a counter of 16 bits.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/rigsim/can_wire.hpp"

namespace rigsim {

inline constexpr int kMostCanMasses = 0x7F;

// `channel` as Device counts: 0 the table, then the masses, then the force. NaN: no number (integers: the lowest code).
[[nodiscard]] WireFrame can_frame(std::size_t channel, bool force, double si, std::uint16_t counter);

// The text of the DBC file for these channels; `cycle_ms` is what it states.
[[nodiscard]] std::string can_dbc(const std::vector<std::string>& channels, bool clamped, double cycle_ms);

}  // namespace rigsim
