// All nodes of one bus, the SYNC that they answer, and the samples that their answers are.
//
// What a node samples at a SYNC carries the instant of the SYNC, the same for every node: that of the SYNC as it went
// out on the bus where the interface tells (its own frames come back with a stamp), else that of handing it over. All
// answers to one SYNC are one scan, pushed when the next SYNC is due, at the latest after 50 ms: only then is it known
// that each node has answered once (attribution.hpp). Answers that come later are counted and given up.
//
// A state machine on frames and time: `now_ns` is CLOCK_MONOTONIC, the instants of frames and SYNCs are
// CLOCK_MONOTONIC_RAW. Whoever has it sends what the outbox holds, and a SYNC when it is due. Bound to one thread. The
// path of a sample does not allocate.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "drivers/canopen/attribution.hpp"
#include "drivers/canopen/node.hpp"
#include "drivers/canopen/outbox.hpp"
#include "drivers/canopen/setup.hpp"
#include "drivers/common/delivery.hpp"
#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/bus.hpp"

namespace dwell::canopen {

class Network {
 public:
  Network(Setup setup, const driver::Host& host);
  Network(const Network&) = delete;
  Network& operator=(const Network&) = delete;

  // The bus is there: every node is set up.
  void begin(std::int64_t now_ns);
  // It is not: every channel is stale for this reason.
  void hold(dwell_fault fault, const std::string& reason);
  [[nodiscard]] bool held() const noexcept { return delivery_.held(); }

  void take(const socketcan::Frame& frame, std::int64_t now_ns);
  // So many frames were lost on the way in.
  void lost(std::uint64_t frames, std::int64_t now_ns) { delivery_.overflow(frames, setup_.interface, now_ns); }
  void tick(std::int64_t now_ns);
  [[nodiscard]] Outbox& outbox() noexcept { return outbox_; }
  // When tick is needed, or a SYNC due, at the latest.
  [[nodiscard]] std::int64_t next_ns(std::int64_t now_ns) const noexcept;

  // Is a SYNC to be sent now? Everything that has come must have been taken before. If so, it closes the answers to the
  // last one, and either sync_sent or sync_failed follows.
  [[nodiscard]] bool sync_due(std::int64_t now_ns);
  // It was handed over between these two instants.
  void sync_sent(std::int64_t before_raw_ns, std::int64_t after_raw_ns, std::int64_t now_ns) noexcept;
  void sync_failed(const std::string& why) noexcept;

  // The socket's filters: what nodes send, and SYNC.
  [[nodiscard]] static std::vector<can_filter> filters(const Setup& setup);

 private:
  // One TPDO.
  struct Stream {
    Pdo pdo;
    Attribution attribution;
    std::array<std::uint8_t, CAN_MAX_DLEN> data{};  // of the last answer
    std::uint8_t size = 0;
    bool asked = false;                       // it was there when the last SYNC went out
    bool answered = false;                    // once at least
    std::int64_t seen_ns = 0;                 // of its last answer; before the first: of the node's start
    std::int64_t gave_up_ns = INT64_MIN / 2;  // when an answer came last that was given up
    dwell_fault told = DWELL_FAULT_NONE;      // of this TPDO alone: too late, or silent while others answer
  };
  struct Member {
    Node node;
    std::vector<Stream> streams;
    unsigned starts = 0;  // that the streams are of
  };
  struct Sync {
    std::int64_t before_ns = 0, t_ns = 0;
    std::uint32_t t_half_ns = 0;
    bool returned = false;
  };

  void take_sync(const socketcan::Frame& frame) noexcept;
  void take_answer(Member& member, const socketcan::Frame& frame, std::int64_t now_ns) noexcept;
  void follow(Member& member);
  void close_window(std::int64_t now_ns) noexcept;
  void close(Member& member, Stream& stream, std::int64_t now_ns) noexcept;
  void deliver(const Stream& stream, std::int64_t now_ns) noexcept;
  void pause_if_needed(std::int64_t now_ns) noexcept;
  void watch_silence(std::int64_t now_ns);
  void watch_streams(Member& member, std::int64_t now_ns);
  void tell(Stream& stream, dwell_fault fault, const std::string& reason) noexcept;

  Setup setup_;
  driver::Host host_;
  Outbox outbox_;
  std::vector<Member> members_;
  std::array<Member*, 128> by_id_{};
  driver::Delivery delivery_;
  bool running_ = false;      // SYNCs are sent
  bool window_open_ = false;  // answers to sync_ are awaited
  Sync sync_;
  bool sync_returns_ = false;  // our own frames come back
  std::int64_t last_sync_ns_ = 0, next_sync_ns_ = 0, next_pause_ns_ = 0;
  std::int64_t next_trial_ns_ = 0;  // of the next pause for TPDOs that were too slow alone
  std::string sync_failure_;
  bool told_foreign_ = false;
  std::int64_t next_watch_ns_ = 0;
};

}  // namespace dwell::canopen
