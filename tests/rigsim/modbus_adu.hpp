// Modbus frames as a server sees them: requests out of the bytes received, answers into bytes, for TCP (MBAP header)
// and RTU (CRC). Pure; no bytes whatever make it fail in any other way than by saying `broken`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace rigsim {

using Bytes = std::vector<std::uint8_t>;

// Modbus exception codes.
inline constexpr std::uint8_t kIllegalFunction = 1;
inline constexpr std::uint8_t kIllegalAddress = 2;
inline constexpr std::uint8_t kIllegalValue = 3;
inline constexpr std::uint8_t kDeviceFailure = 4;
inline constexpr std::uint8_t kNoSuchTarget = 0x0B;

struct Request {
  std::uint16_t transaction = 0;  // TCP
  std::uint8_t unit = 0;
  std::uint8_t function = 0;
  std::uint16_t address = 0;  // of functions 3 and 4
  std::uint16_t count = 0;
  std::size_t size = 0;        // bytes on the wire
  std::uint8_t exception = 0;  // not 0: cannot be served, this is the answer
};

struct Parsed {
  enum class Kind : std::uint8_t { incomplete, request, broken };
  Kind kind = Kind::incomplete;
  Request request;  // request.size bytes have been consumed
};

// The first frame in `bytes`. broken: what follows cannot be made out (TCP: close; RTU: wait for silence).
[[nodiscard]] Parsed parse_tcp(std::span<const std::uint8_t> bytes) noexcept;
[[nodiscard]] Parsed parse_rtu(std::span<const std::uint8_t> bytes) noexcept;

// CRC-16/MODBUS; sent low byte first.
[[nodiscard]] std::uint16_t crc16(std::span<const std::uint8_t> bytes) noexcept;

// Answers (function and what follows).
[[nodiscard]] Bytes exception_pdu(const Request& request, std::uint8_t code);
[[nodiscard]] Bytes registers_pdu(const Request& request, std::span<const std::uint16_t> registers);

[[nodiscard]] Bytes tcp_frame(std::uint16_t transaction, std::uint8_t unit, std::span<const std::uint8_t> pdu);
[[nodiscard]] Bytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu);

}  // namespace rigsim
