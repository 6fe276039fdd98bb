#include "tests/rigsim/can_frames.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace rigsim {
namespace {

constexpr canid_t kMotion = 0x200;
constexpr canid_t kLoadCell = 0x18FF5021;  // group 65360 from address 33
constexpr double kMetresPerCount = 1e-9;

void put(canfd_frame& frame, std::size_t first, std::uint32_t bits, bool intel) {
  for (std::size_t i = 0; i < 4; ++i)
    frame.data[first + (intel ? i : 3 - i)] = static_cast<std::uint8_t>(bits >> (8 * i));
}

}  // namespace

WireFrame can_frame(std::size_t channel, bool force, double si, std::uint16_t counter) {
  WireFrame sent;
  canfd_frame& frame = sent.can;
  frame.len = 8;
  frame.data[6] = static_cast<std::uint8_t>(counter);
  frame.data[7] = static_cast<std::uint8_t>(counter >> 8U);
  if (force) {
    frame.can_id = kLoadCell | CAN_EFF_FLAG;
    put(frame, 0, std::bit_cast<std::uint32_t>(static_cast<float>(si)), true);
    return sent;
  }
  frame.can_id = kMotion + static_cast<canid_t>(channel);
  if (channel % 2 == 1) {
    put(frame, 1, std::bit_cast<std::uint32_t>(static_cast<float>(1e3 * si)), false);
  } else {
    const double counts = std::isnan(si) ? -2147483648.0 : std::nearbyint(si / kMetresPerCount);
    put(frame, 0,
        static_cast<std::uint32_t>(static_cast<std::int32_t>(std::clamp(counts, -2147483648.0, 2147483647.0))), true);
  }
  return sent;
}

std::string can_dbc(const std::vector<std::string>& channels, bool clamped, double cycle_ms) {
  std::string text = "VERSION \"\"\n\nNS_ :\n\nBS_:\n\nBU_: Rig\n\n", types, cycles;
  for (std::size_t k = 0; k < channels.size(); ++k) {
    const bool force = clamped && k + 1 == channels.size();
    const canid_t id = force ? kLoadCell | CAN_EFF_FLAG : kMotion + static_cast<canid_t>(k);
    const std::string number = std::to_string(id);
    const std::string name = force ? "LoadCell" : "Motion" + std::to_string(k);
    text += "BO_ " + number + " " + name + ": 8 Rig\n";
    if (force) {
      text += " SG_ Force : 0|32@1- (1,0) [0|0] \"N\" Vector__XXX\n";
      types += "SIG_VALTYPE_ " + number + " Force : 1;\n";
    } else if (k % 2 == 1) {
      text += " SG_ Selector M : 0|8@1+ (1,0) [0|0] \"\" Vector__XXX\n";
      text += " SG_ Position m0 : 15|32@0- (1,0) [0|0] \"mm\" Vector__XXX\n";
      types += "SIG_VALTYPE_ " + number + " Position : 1;\n";
    } else {
      text += " SG_ Position : 0|32@1- (1E-06,0) [0|0] \"mm\" Vector__XXX\n";
    }
    text += " SG_ Counter : 48|16@1+ (1,0) [0|0] \"\" Vector__XXX\n\n";
    cycles +=
        "BA_ \"GenMsgCycleTime\" BO_ " + number + " " + std::to_string(std::max(1L, std::lround(cycle_ms))) + ";\n";
    if (force) cycles += "BA_ \"VFrameFormat\" BO_ " + number + " 3;\n";
  }
  text += "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\",\"J1939PG\";\n";
  text += "BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\n";
  text += "BA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN\";\nBA_DEF_DEF_ \"GenMsgCycleTime\" 0;\n";
  return text + cycles + types;
}

}  // namespace rigsim
