// What CANopen's numbers mean, for people: SDO abort codes, emergencies, node states, objects.
#pragma once

#include <cstdint>
#include <string>

#include "drivers/canopen/message.hpp"
#include "drivers/common/words.hpp"

namespace dwell::canopen {

using driver::seconds;

// "9130h:01"
[[nodiscard]] std::string to_string(const Object& object);
// "0x185"
[[nodiscard]] std::string hex(std::uint32_t value);

// "object does not exist in the object dictionary (0x06020000)"
[[nodiscard]] std::string abort_text(std::uint32_t code);
// "0x4210 (device temperature)"
[[nodiscard]] std::string emergency_text(std::uint16_t code);
// "0x09 (generic, temperature)"
[[nodiscard]] std::string error_register_text(std::uint8_t bits);
// "pre-operational"
[[nodiscard]] std::string state_text(std::uint8_t state);

}  // namespace dwell::canopen
