// The requests of one Modbus TCP client and the answers to them, without a socket: bytes in, bytes out. Functions 3 and
// 4 read the same registers; every other function is refused. Any unit id is answered, and comes back in the answer.
//
// Bounded: one request of at most 260 bytes and one answer of at most 259. No byte beyond the request under way is
// taken, so a client that sends ahead fills the kernel's buffer alone. Bound to one thread; allocates nothing.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace dwell {

// Gives registers first … first + count - 1, valid until the next call; empty: some do not exist, or one read may not
// hold them all. count: 1 to 125.
using ReadRegisters = std::function<std::span<const std::uint16_t>(std::uint16_t first, std::uint16_t count)>;

class ModbusConversation {
 public:
  enum class Turn : std::uint8_t {
    more,     // the request goes on
    answer,   // answer() is the answer
    refused,  // answer() is an exception: it says what was wrong with the request
    broken,   // this is not Modbus TCP: nobody can know where the next request would begin
  };

  // Where the next bytes go. Its size: the bytes that the request under way is known to lack, at least 1.
  [[nodiscard]] std::span<std::uint8_t> room() noexcept;
  // To be told that `count` bytes were put into room(), 1 to its size. Must not be called after `broken`.
  Turn received(std::size_t count, const ReadRegisters& read);
  // Valid until the next call of received().
  [[nodiscard]] std::span<const std::uint8_t> answer() const noexcept { return {answer_.data(), answered_}; }
  // Whether a request has begun and has not ended.
  [[nodiscard]] bool under_way() const noexcept { return have_ > 0; }

 private:
  // Bytes of the header: transaction id (2), protocol id (2), length (2), unit id (1). The length counts the unit id
  // and all bytes behind it (Modbus Messaging on TCP/IP 1.0b, 3.1.3).
  static constexpr std::size_t kHeader = 7;
  static constexpr std::size_t kMostBytes = 260;  // a request, its header included (4.1)

  [[nodiscard]] std::size_t length() const noexcept;  // the header's, bytes
  Turn answer_request(const ReadRegisters& read);
  Turn refuse(std::uint8_t code);

  std::array<std::uint8_t, kMostBytes> request_{};
  std::array<std::uint8_t, kMostBytes> answer_{};
  std::size_t have_ = 0;      // bytes of the request
  std::size_t answered_ = 0;  // bytes of the answer
};

}  // namespace dwell
