// One Modbus TCP client's requests and the answers to them, without a socket: bytes in, bytes out. Reading only:
// functions 3 and 4, which read the same registers. The unit id is not looked at and comes back as it came.
//
// Bounded: it holds one request of at most 260 bytes and one answer of at most 259. It asks for no byte beyond the
// request under way, so a client that sends ahead fills the kernel's buffer, and no other. Bound to one thread;
// allocates nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace dwell {

// Registers first … first + count - 1, which stay until the next call; empty: not all of them exist, or not in one
// read. count is 1 to 125.
using ReadRegisters = std::function<std::span<const std::uint16_t>(std::uint16_t first, std::uint16_t count)>;

class ModbusConversation {
 public:
  enum class Turn : std::uint8_t {
    more,     // the request goes on
    answer,   // answer() is the answer
    refused,  // answer() is an exception: it says what was wrong with the request
    broken,   // this is not Modbus TCP: where the next request would begin cannot be known
  };

  // Where the next bytes go: as many as the request under way is known to lack. Never empty.
  [[nodiscard]] std::span<std::uint8_t> room() noexcept;
  // So many bytes have been put into room(), at least 1 and at most its size. After `broken` it must not be called.
  Turn received(std::size_t count, const ReadRegisters& read);
  // Until the next call of received().
  [[nodiscard]] std::span<const std::uint8_t> answer() const noexcept { return {answer_.data(), answered_}; }
  // Whether a request has begun and has not ended.
  [[nodiscard]] bool under_way() const noexcept { return have_ > 0; }

 private:
  // Transaction id, protocol id, length of what follows, unit id (Modbus Messaging on TCP/IP 1.0b, 3.1.3).
  static constexpr std::size_t kHeader = 7;
  static constexpr std::size_t kMostBytes = 260;  // a request, its header included (4.1)

  [[nodiscard]] std::size_t length() const noexcept;  // the header's: of the unit id and what follows
  Turn answer_request(const ReadRegisters& read);
  Turn refuse(std::uint8_t code);

  std::array<std::uint8_t, kMostBytes> request_{};
  std::array<std::uint8_t, kMostBytes> answer_{};
  std::size_t have_ = 0;      // bytes of the request
  std::size_t answered_ = 0;  // bytes of the answer
};

}  // namespace dwell
