#include "daemon/serve/modbus_conversation.hpp"

#include <algorithm>

namespace dwell {
namespace {

constexpr std::uint8_t kReadHolding = 3, kReadInput = 4;
constexpr std::uint8_t kException = 0x80;
constexpr std::uint8_t kIllegalFunction = 1, kIllegalAddress = 2, kIllegalValue = 3;
// Registers of one answer (Modbus Application Protocol 1.1b3, 6.3 and 6.4).
constexpr std::size_t kMostRegisters = 125;

std::uint16_t word_at(const std::uint8_t* bytes) { return static_cast<std::uint16_t>(bytes[0] << 8 | bytes[1]); }

void put_word(std::uint8_t* bytes, std::size_t word) {
  bytes[0] = static_cast<std::uint8_t>(word >> 8);
  bytes[1] = static_cast<std::uint8_t>(word);
}

}  // namespace

std::size_t ModbusConversation::length() const noexcept { return word_at(request_.data() + 4); }

std::span<std::uint8_t> ModbusConversation::room() noexcept {
  const std::size_t known = have_ < kHeader ? kHeader : kHeader - 1 + length();
  return {request_.data() + have_, known - have_};
}

ModbusConversation::Turn ModbusConversation::received(std::size_t count, const ReadRegisters& read) {
  have_ += count;
  if (have_ < kHeader) return Turn::more;
  // At least the unit id and a function; at most a whole request.
  const bool sound = word_at(request_.data() + 2) == 0 && length() >= 2 && length() <= kMostBytes - (kHeader - 1);
  if (!sound) return Turn::broken;
  if (have_ < kHeader - 1 + length()) return Turn::more;
  const Turn turn = answer_request(read);
  have_ = 0;
  return turn;
}

ModbusConversation::Turn ModbusConversation::answer_request(const ReadRegisters& read) {
  const std::uint8_t* const asked = request_.data() + kHeader;  // function, first register, count
  std::copy_n(request_.begin(), kHeader, answer_.begin());
  answer_[kHeader] = asked[0];
  if (asked[0] != kReadHolding && asked[0] != kReadInput) return refuse(kIllegalFunction);
  constexpr std::size_t kReadLength = 6;  // unit id, function, two words
  if (length() != kReadLength) return refuse(kIllegalValue);
  const std::uint16_t first = word_at(asked + 1), count = word_at(asked + 3);
  if (count < 1 || count > kMostRegisters) return refuse(kIllegalValue);
  const std::span<const std::uint16_t> registers = read(first, count);
  if (registers.size() != count) return refuse(kIllegalAddress);
  put_word(answer_.data() + 4, 3 + 2 * registers.size());
  answer_[kHeader + 1] = static_cast<std::uint8_t>(2 * registers.size());
  for (std::size_t i = 0; i < registers.size(); ++i) put_word(answer_.data() + kHeader + 2 + 2 * i, registers[i]);
  answered_ = kHeader + 2 + 2 * registers.size();
  return Turn::answer;
}

ModbusConversation::Turn ModbusConversation::refuse(std::uint8_t code) {
  put_word(answer_.data() + 4, 3);
  answer_[kHeader] = static_cast<std::uint8_t>(answer_[kHeader] | kException);
  answer_[kHeader + 1] = code;
  answered_ = kHeader + 2;
  return Turn::refused;
}

}  // namespace dwell
