#include "tests/rigsim/modbus_adu.hpp"

#include <array>

namespace rigsim {
namespace {

constexpr std::size_t kHeader = 7;
constexpr std::uint16_t kMostRegisters = 125;

std::uint16_t word_at(std::span<const std::uint8_t> bytes, std::size_t i) noexcept {
  return static_cast<std::uint16_t>(bytes[i] << 8 | bytes[i + 1]);
}

void append(Bytes& bytes, std::uint16_t word) {
  bytes.push_back(static_cast<std::uint8_t>(word >> 8));
  bytes.push_back(static_cast<std::uint8_t>(word & 0xFF));
}

// Function and what follows into the request.
void take_pdu(Request& request, std::span<const std::uint8_t> pdu) noexcept {
  request.function = pdu[0];
  if (request.function != 3 && request.function != 4) {
    request.exception = kIllegalFunction;
    return;
  }
  if (pdu.size() != 5) {
    request.exception = kIllegalValue;
    return;
  }
  request.address = word_at(pdu, 1);
  request.count = word_at(pdu, 3);
  if (request.count == 0 || request.count > kMostRegisters) request.exception = kIllegalValue;
}

// Bytes of an RTU request by its function; 0: not known (yet).
std::size_t rtu_size(std::span<const std::uint8_t> bytes, bool& unknown) noexcept {
  unknown = false;
  if (bytes.size() < 2) return 0;
  switch (bytes[1]) {
    case 1:
    case 2:
    case 3:
    case 4:
    case 5:
    case 6:
    case 8:
      return 8;
    case 7:
    case 11:
    case 12:
    case 17:
      return 4;
    case 15:
    case 16:
      return bytes.size() < 7 ? 0 : std::size_t{9} + bytes[6];
    case 22:
      return 10;
    case 23:
      return bytes.size() < 11 ? 0 : std::size_t{13} + bytes[10];
    default:
      unknown = true;
      return 0;
  }
}

constexpr std::array<std::uint16_t, 256> make_crc_table() noexcept {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    auto crc = static_cast<std::uint16_t>(i);
    for (int bit = 0; bit < 8; ++bit)
      crc = static_cast<std::uint16_t>((crc & 1U) != 0 ? (crc >> 1) ^ 0xA001U : crc >> 1);
    table[i] = crc;
  }
  return table;
}
constexpr auto kCrcTable = make_crc_table();

}  // namespace

std::uint16_t crc16(std::span<const std::uint8_t> bytes) noexcept {
  std::uint16_t crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) crc = static_cast<std::uint16_t>((crc >> 8) ^ kCrcTable[(crc ^ byte) & 0xFFU]);
  return crc;
}

Parsed parse_tcp(std::span<const std::uint8_t> bytes) noexcept {
  Parsed parsed;
  if (bytes.size() < kHeader) return parsed;
  const std::uint16_t length = word_at(bytes, 4);
  if (word_at(bytes, 2) != 0 || length < 2 || length > 254) {
    parsed.kind = Parsed::Kind::broken;
    return parsed;
  }
  const std::size_t size = std::size_t{6} + length;
  if (bytes.size() < size) return parsed;
  parsed.kind = Parsed::Kind::request;
  parsed.request.transaction = word_at(bytes, 0);
  parsed.request.unit = bytes[6];
  parsed.request.size = size;
  take_pdu(parsed.request, bytes.subspan(kHeader, size - kHeader));
  return parsed;
}

Parsed parse_rtu(std::span<const std::uint8_t> bytes) noexcept {
  Parsed parsed;
  bool unknown = false;
  const std::size_t size = rtu_size(bytes, unknown);
  if (unknown) parsed.kind = Parsed::Kind::broken;
  if (size == 0 || bytes.size() < size) return parsed;
  const std::uint16_t crc = crc16(bytes.first(size - 2));
  if (bytes[size - 2] != (crc & 0xFF) || bytes[size - 1] != crc >> 8) {
    parsed.kind = Parsed::Kind::broken;
    return parsed;
  }
  parsed.kind = Parsed::Kind::request;
  parsed.request.unit = bytes[0];
  parsed.request.size = size;
  take_pdu(parsed.request, bytes.subspan(1, size - 3));
  return parsed;
}

Bytes exception_pdu(const Request& request, std::uint8_t code) {
  return {static_cast<std::uint8_t>(request.function | 0x80U), code};
}

Bytes registers_pdu(const Request& request, std::span<const std::uint16_t> registers) {
  Bytes pdu;
  pdu.reserve(2 + 2 * registers.size());
  pdu.push_back(request.function);
  pdu.push_back(static_cast<std::uint8_t>(2 * registers.size()));
  for (const std::uint16_t word : registers) append(pdu, word);
  return pdu;
}

Bytes tcp_frame(std::uint16_t transaction, std::uint8_t unit, std::span<const std::uint8_t> pdu) {
  Bytes frame;
  frame.reserve(kHeader + pdu.size());
  append(frame, transaction);
  append(frame, 0);
  append(frame, static_cast<std::uint16_t>(pdu.size() + 1));
  frame.push_back(unit);
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  return frame;
}

Bytes rtu_frame(std::uint8_t unit, std::span<const std::uint8_t> pdu) {
  Bytes frame;
  frame.reserve(pdu.size() + 3);
  frame.push_back(unit);
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  const std::uint16_t crc = crc16(frame);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFF));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8));
  return frame;
}

}  // namespace rigsim
