#include "drivers/canopen/words.hpp"

#include <cstdio>

namespace dwell::canopen {
namespace {

struct Meaning {
  std::uint32_t code;
  const char* text;
};

// CiA 301, table of SDO abort codes.
constexpr Meaning kAborts[] = {
    {0x05030000, "toggle bit not alternated"},
    {0x05040000, "SDO protocol timed out"},
    {0x05040001, "command specifier not valid or unknown"},
    {0x05040002, "invalid block size"},
    {0x05040003, "invalid sequence number"},
    {0x05040004, "CRC error"},
    {0x05040005, "out of memory"},
    {0x06010000, "unsupported access to an object"},
    {0x06010001, "attempt to read a write only object"},
    {0x06010002, "attempt to write a read only object"},
    {0x06020000, "object does not exist in the object dictionary"},
    {0x06040041, "object cannot be mapped to the PDO"},
    {0x06040042, "the objects to be mapped would exceed the PDO's length"},
    {0x06040043, "general parameter incompatibility"},
    {0x06040047, "general internal incompatibility in the device"},
    {0x06060000, "access failed due to a hardware error"},
    {0x06070010, "data type does not match, length does not match"},
    {0x06070012, "data type does not match, length too high"},
    {0x06070013, "data type does not match, length too low"},
    {0x06090011, "sub-index does not exist"},
    {0x06090030, "invalid value for the parameter"},
    {0x06090031, "value of the parameter too high"},
    {0x06090032, "value of the parameter too low"},
    {0x06090036, "maximum value is less than minimum value"},
    {0x060A0023, "resource not available: SDO connection"},
    {0x08000000, "general error"},
    {0x08000020, "data cannot be transferred or stored to the application"},
    {0x08000021, "data cannot be transferred or stored because of local control"},
    {0x08000022, "data cannot be transferred or stored because of the present device state"},
    {0x08000023, "no object dictionary is present"},
    {0x08000024, "no data available"},
};

// CiA 301, emergency error codes: the class is the high byte, some are told apart by more of it. The first that fits.
struct Class {
  std::uint16_t mask;
  std::uint16_t code;
  const char* text;
};
constexpr Class kEmergencies[] = {
    {0xFF00, 0x0000, "error reset or no error"},
    {0xFF00, 0x1000, "generic error"},
    {0xFF00, 0x2100, "current, device input side"},
    {0xFF00, 0x2200, "current inside the device"},
    {0xFF00, 0x2300, "current, device output side"},
    {0xF000, 0x2000, "current"},
    {0xFF00, 0x3100, "mains voltage"},
    {0xFF00, 0x3200, "voltage inside the device"},
    {0xFF00, 0x3300, "output voltage"},
    {0xF000, 0x3000, "voltage"},
    {0xFF00, 0x4100, "ambient temperature"},
    {0xFF00, 0x4200, "device temperature"},
    {0xF000, 0x4000, "temperature"},
    {0xFF00, 0x5000, "device hardware"},
    {0xFF00, 0x6100, "internal software"},
    {0xFF00, 0x6200, "user software"},
    {0xFF00, 0x6300, "data set"},
    {0xF000, 0x6000, "device software"},
    {0xFF00, 0x7000, "additional modules"},
    {0xFFFF, 0x8110, "CAN overrun, objects lost"},
    {0xFFFF, 0x8120, "CAN in error passive mode"},
    {0xFFFF, 0x8130, "life guard or heartbeat error"},
    {0xFFFF, 0x8140, "recovered from bus off"},
    {0xFFFF, 0x8150, "CAN-ID collision"},
    {0xFF00, 0x8100, "communication"},
    {0xFFFF, 0x8210, "PDO not processed due to length error"},
    {0xFFFF, 0x8220, "PDO length exceeded"},
    {0xFF00, 0x8200, "protocol error"},
    {0xF000, 0x8000, "monitoring"},
    {0xFF00, 0x9000, "external error"},
    {0xFF00, 0xF000, "additional functions"},
    {0xFF00, 0xFF00, "device specific"},
};

constexpr const char* kRegister[] = {"generic",       "current",        "voltage",  "temperature",
                                     "communication", "device profile", "reserved", "manufacturer"};

template <class... Values>
std::string printed(const char* format, Values... values) {
  char text[64];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

std::string to_string(const Object& object) { return printed("%04Xh:%02X", object.index, object.sub_index); }

std::string hex(std::uint32_t value) { return printed("0x%X", value); }

std::string abort_text(std::uint32_t code) {
  for (const Meaning& each : kAborts)
    if (each.code == code) return each.text + printed(" (0x%08X)", code);
  return printed("unknown abort code 0x%08X", code);
}

std::string emergency_text(std::uint16_t code) {
  for (const Class& each : kEmergencies)
    if ((code & each.mask) == each.code) return printed("0x%04X (", code) + each.text + ")";
  return printed("0x%04X", code);
}

std::string error_register_text(std::uint8_t bits) {
  std::string text;
  for (unsigned i = 0; i < 8; ++i)
    if ((bits >> i & 1U) != 0) text += (text.empty() ? "" : ", ") + std::string(kRegister[i]);
  return printed("0x%02X (", bits) + (text.empty() ? "none" : text) + ")";
}

std::string state_text(std::uint8_t state) {
  switch (static_cast<Nmt>(state)) {
    case Nmt::boot_up:
      return "booting";
    case Nmt::stopped:
      return "stopped";
    case Nmt::operational:
      return "operational";
    case Nmt::pre_operational:
      return "pre-operational";
  }
  return "in the unknown state " + std::to_string(state);
}

}  // namespace dwell::canopen
