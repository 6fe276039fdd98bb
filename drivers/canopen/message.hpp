// CANopen's messages as plain frames (CiA 301): identifiers, little-endian numbers, objects. All of it pure; nothing
// allocates.
#pragma once

#include <linux/can.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <span>

namespace dwell::canopen {

// Identifiers of the predefined connection set; a node's own is added.
inline constexpr canid_t kNmt = 0x000, kSync = 0x080, kEmergency = 0x080, kFirstPdo = 0x180, kLastPdo = 0x57F,
                         kSdoAnswer = 0x580, kSdoRequest = 0x600, kHeartbeat = 0x700;
inline constexpr canid_t kNodeMask = 0x07F;

enum class Command : std::uint8_t { start = 0x01, pre_operational = 0x80, reset_communication = 0x82 };

// What a heartbeat tells of a node.
enum class Nmt : std::uint8_t { boot_up = 0x00, stopped = 0x04, operational = 0x05, pre_operational = 0x7F };

// An entry of an object dictionary.
struct Object {
  std::uint16_t index = 0;
  std::uint8_t sub_index = 0;

  friend bool operator==(const Object&, const Object&) = default;
};

inline can_frame make_frame(canid_t id, std::initializer_list<std::uint8_t> bytes) noexcept {
  can_frame frame{};
  frame.can_id = id;
  frame.can_dlc = static_cast<std::uint8_t>(std::min<std::size_t>(bytes.size(), CAN_MAX_DLEN));
  std::copy_n(bytes.begin(), frame.can_dlc, frame.data);
  return frame;
}

inline can_frame nmt_frame(Command command, std::uint8_t node) noexcept {
  return make_frame(kNmt, {static_cast<std::uint8_t>(command), node});
}

// CANopen knows classic frames alone; sockets carry both kinds.
[[nodiscard]] inline canfd_frame wide(const can_frame& frame) noexcept {
  canfd_frame made{};
  made.can_id = frame.can_id;
  made.len = frame.can_dlc;
  std::copy_n(frame.data, CAN_MAX_DLEN, made.data);
  return made;
}
[[nodiscard]] inline can_frame classic(const canfd_frame& frame) noexcept {
  can_frame made{};
  made.can_id = frame.can_id;
  made.can_dlc = std::min<std::uint8_t>(frame.len, CAN_MAX_DLEN);
  std::copy_n(frame.data, CAN_MAX_DLEN, made.data);
  return made;
}

inline void put_le(std::span<std::uint8_t> bytes, std::uint64_t value) noexcept {
  for (std::uint8_t& byte : bytes) {
    byte = static_cast<std::uint8_t>(value);
    value >>= 8U;
  }
}

// At most 8 bytes.
[[nodiscard]] inline std::uint64_t get_le(std::span<const std::uint8_t> bytes) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = std::min<std::size_t>(bytes.size(), 8); i > 0; --i) value = value << 8U | bytes[i - 1];
  return value;
}

}  // namespace dwell::canopen
