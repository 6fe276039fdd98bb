// Asks one node for objects of its dictionary (SDO, CiA 301): one request at a time, read expedited or in segments,
// written expedited. A pure state machine on frames and time: whoever has it hands in the node's answers and the time,
// and sends what it gives.
//
//   client.upload({0x1018, 1}, now_ns);
//   … while (auto frame = client.to_send()) send(*frame);  client.take(answer, now_ns);  client.tick(now_ns);
//   … client.state() == SdoClient::State::done: client.data()
//
// A request without an answer in time is aborted and, after a pause in which whatever still comes is known to be late,
// asked again. An answer is taken only if it is to the object that is asked for, and in turn; others are counted. Only
// an answer that comes after that pause, to the same object, cannot be told from the new one.
//
// Bound to one thread. Nothing allocates.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "drivers/canopen/message.hpp"

namespace dwell::canopen {

class SdoClient {
 public:
  enum class State : std::uint8_t {
    idle,
    busy,
    done,
    aborted,   // by the node, or by us for what it sent: abort_code()
    no_answer  // to any of the attempts
  };
  static constexpr std::size_t kMostBytes = 128;  // of a value; a longer one is aborted
  static constexpr std::int64_t kTimeout_ns = 250'000'000, kPause_ns = 250'000'000;
  static constexpr int kAttempts = 3;

  explicit SdoClient(std::uint8_t node) noexcept : node_(node) {}

  // Both forget what was asked before.
  void upload(const Object& object, std::int64_t now_ns) noexcept { begin(object, {}, now_ns); }
  // 1 to 4 bytes.
  void download(const Object& object, std::uint32_t value, std::uint8_t size, std::int64_t now_ns) noexcept;
  void cancel() noexcept;

  // An answer of this node (identifier kSdoAnswer + node).
  void take(const can_frame& answer, std::int64_t now_ns) noexcept;
  void tick(std::int64_t now_ns) noexcept;
  // What is to be sent now, handed out once.
  [[nodiscard]] std::optional<can_frame> to_send() noexcept;

  [[nodiscard]] State state() const noexcept { return state_; }
  [[nodiscard]] const Object& object() const noexcept { return request_.object; }
  // When done: what was read.
  [[nodiscard]] std::span<const std::uint8_t> data() const noexcept { return {answer_.bytes.data(), answer_.size}; }
  // Whether the node said how long that is; if not, it is four bytes, of which the object's width counts.
  [[nodiscard]] bool sized() const noexcept { return answer_.sized; }
  [[nodiscard]] std::uint32_t abort_code() const noexcept { return abort_code_; }
  // Answers that belonged to nothing that was asked, since the last call.
  [[nodiscard]] unsigned take_late() noexcept;

 private:
  enum class Phase : std::uint8_t { none, initiate, segment, pause };

  // What is asked for. It is a download if it has bytes.
  struct Request {
    Object object;
    std::array<std::uint8_t, 4> value{};
    std::uint8_t size = 0;  // bytes of the value
    [[nodiscard]] bool writes() const noexcept { return size > 0; }
  };
  // What the node has answered so far.
  struct Answer {
    std::array<std::uint8_t, kMostBytes> bytes{};
    std::size_t size = 0;
    bool sized = true;          // by the node's word
    std::size_t announced = 0;  // bytes, of an answer in segments; 0: the node did not say
    bool toggle = false;        // of the segment that comes next
  };

  void begin(const Object& object, std::span<const std::uint8_t> value, std::int64_t now_ns) noexcept;
  void ask(std::int64_t now_ns) noexcept;
  void ask_segment(std::int64_t now_ns) noexcept;
  void finish(State state, std::uint32_t abort_code = 0) noexcept;
  void abort_and_finish(std::uint32_t code) noexcept;
  void abort_and_pause(std::uint32_t code, std::int64_t now_ns) noexcept;
  void take_initiated(const can_frame& answer, std::int64_t now_ns) noexcept;
  void take_segment(const can_frame& answer, std::int64_t now_ns) noexcept;

  std::uint8_t node_;
  State state_ = State::idle;
  Phase phase_ = Phase::none;
  Request request_;
  int attempts_ = 0;
  Answer answer_;
  std::uint32_t abort_code_ = 0;
  unsigned late_ = 0;
  std::int64_t deadline_ns_ = 0;
  std::optional<can_frame> to_send_;
};

}  // namespace dwell::canopen
