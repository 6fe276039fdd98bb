// Whatever a Modbus client sends, in whatever pieces: it is answered within the protocol's bounds, from registers that
// exist, or its connection ends. The bytes are the size of each piece, then the piece.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "daemon/serve/modbus_conversation.hpp"
#include "tests/drivers/fuzz_bytes.hpp"

namespace {

using dwell::ModbusConversation;
using dwell::test::Bytes, dwell::test::hold;

constexpr std::size_t kRegisters = 1325;  // seven pages

// An answer belongs to its request and is as long as it says.
void check(ModbusConversation::Turn turn, std::span<const std::uint8_t> answer, std::size_t handed_out) {
  hold(answer.size() >= 9 && answer.size() <= 259);
  hold(answer[2] == 0 && answer[3] == 0 && static_cast<std::size_t>(answer[4] << 8 | answer[5]) + 6 == answer.size());
  if (turn == ModbusConversation::Turn::answer) {
    hold((answer[7] == 3 || answer[7] == 4) && handed_out >= 1 && handed_out <= 125);
    hold(answer[8] == 2 * handed_out && answer.size() == 9U + answer[8]);
  } else {
    hold(answer.size() == 9 && (answer[7] & 0x80U) != 0 && answer[8] >= 1 && answer[8] <= 3);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  ModbusConversation conversation;
  std::vector<std::uint16_t> registers;  // on the heap and as long as asked for: what lies beyond is found
  while (!bytes.empty()) {
    auto piece = bytes.take_some(bytes.take<std::uint8_t>());
    while (!piece.empty()) {
      const auto room = conversation.room();
      hold(!room.empty() && room.size() <= 260);
      const std::size_t count = std::min(room.size(), piece.size());
      std::copy_n(piece.begin(), count, room.begin());
      piece = piece.subspan(count);
      registers.clear();
      const auto turn = conversation.received(count, [&](std::uint16_t first, std::uint16_t asked) {
        hold(asked >= 1 && asked <= 125);
        if (first + asked <= kRegisters) registers = std::vector<std::uint16_t>(asked, first);
        return std::span<const std::uint16_t>(registers);
      });
      if (turn == ModbusConversation::Turn::broken) return 0;
      if (turn == ModbusConversation::Turn::more) continue;
      check(turn, conversation.answer(), registers.size());
      hold(!conversation.under_way());
    }
  }
  return 0;
}
