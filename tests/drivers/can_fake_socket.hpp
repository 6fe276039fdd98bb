// A socket that a test scripts: what each read finds, and what was written.
#pragma once

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <vector>

#include "drivers/dwell_driver.hpp"
#include "drivers/socketcan/socket.hpp"

namespace dwell::test {

// One bus that outlives the sockets opened on it. May be used from any thread.
class FakeBus {
 public:
  FakeBus() : event_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}
  ~FakeBus() { ::close(event_); }
  FakeBus(const FakeBus&) = delete;
  FakeBus& operator=(const FakeBus&) = delete;

  socketcan::Open opener() {
    return [this]() -> socketcan::Opened {
      const std::lock_guard lock(mutex_);
      ++opened_;
      if (!refusal_.empty()) return tl::unexpected(refusal_);
      ++ends_;
      return std::make_unique<End>(*this);
    };
  }
  // Empty: opens.
  void refuse(std::string reason) {
    const std::lock_guard lock(mutex_);
    refusal_ = std::move(reason);
  }
  int opened() const {
    const std::lock_guard lock(mutex_);
    return opened_;
  }

  bool is_open() const {
    const std::lock_guard lock(mutex_);
    return ends_ > 0;
  }

  // A packet that arrives now, with the kernel's stamp.
  void arrive(canid_t id, const std::vector<std::uint8_t>& data) {
    socketcan::Packet packet;
    packet.frame.can_id = id;
    packet.frame.len = static_cast<std::uint8_t>(data.size());
    std::copy(data.begin(), data.end(), packet.frame.data);
    packet.size = data.size() > CAN_MAX_DLEN ? CANFD_MTU : CAN_MTU;
    // Stamped and queued in one step: on a busy machine a pause between the two would make the stamp implausible.
    const std::lock_guard lock(mutex_);
    packet.real_ns = driver::clock_ns(CLOCK_REALTIME);
    packets_.push_back(packet);
    wake();
  }
  void arrive(const socketcan::Packet& packet) {
    const std::lock_guard lock(mutex_);
    packets_.push_back(packet);
    wake();
  }
  // The read that has taken all packets tells it.
  void fail(int error) {
    const std::lock_guard lock(mutex_);
    error_ = error;
    wake();
  }
  // So does every read from now on; 0: no longer.
  void fail_always(int error) {
    const std::lock_guard lock(mutex_);
    error_always_ = error;
    wake();
  }
  void set_link(socketcan::Link link) {
    const std::lock_guard lock(mutex_);
    link_ = link;
  }
  void drop(std::uint32_t frames) {
    const std::lock_guard lock(mutex_);
    dropped_ += frames;
  }
  // Every read finds as much as it has room for, of no meaning.
  void babble(bool on) {
    const std::lock_guard lock(mutex_);
    babbling_ = on;
    wake();
  }
  // What every write gives from now on; 0: it goes out.
  void refuse_writes(int error) {
    const std::lock_guard lock(mutex_);
    write_error_ = error;
  }
  std::vector<canfd_frame> written() const {
    const std::lock_guard lock(mutex_);
    return written_;
  }

 private:
  class End : public socketcan::Socket {
   public:
    explicit End(FakeBus& bus) : bus_(bus) {}
    ~End() override {
      const std::lock_guard lock(bus_.mutex_);
      --bus_.ends_;
    }
    End(const End&) = delete;
    End& operator=(const End&) = delete;
    int descriptor() const noexcept override { return bus_.event_; }
    socketcan::Batch read(std::span<socketcan::Packet> room) noexcept override { return bus_.read(room); }
    socketcan::Link link() const noexcept override {
      const std::lock_guard lock(bus_.mutex_);
      return bus_.link_;
    }
    int write(const canfd_frame& frame, bool) noexcept override {
      const std::lock_guard lock(bus_.mutex_);
      if (bus_.write_error_ == 0) bus_.written_.push_back(frame);
      return bus_.write_error_;
    }

   private:
    FakeBus& bus_;
  };

  socketcan::Batch read(std::span<socketcan::Packet> room) noexcept {
    const std::lock_guard lock(mutex_);
    socketcan::Batch batch;
    for (; batch.count < room.size() && !packets_.empty(); packets_.pop_front()) room[batch.count++] = packets_.front();
    batch.dropped = dropped_;
    while (babbling_ && batch.count < room.size()) {
      room[batch.count] = {};
      room[batch.count++].size = CAN_MTU;
    }
    if (batch.count == room.size()) return batch;
    batch.error = error_always_ != 0 ? error_always_ : std::exchange(error_, 0);
    std::uint64_t woken = 0;
    [[maybe_unused]] const auto got = ::read(event_, &woken, sizeof woken);
    return batch;
  }
  void wake() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(event_, &one, sizeof one);
  }

  int event_;
  mutable std::mutex mutex_;
  std::string refusal_;
  int opened_ = 0, ends_ = 0;
  std::deque<socketcan::Packet> packets_;
  int error_ = 0, error_always_ = 0;
  socketcan::Link link_ = socketcan::Link::up;
  std::uint32_t dropped_ = 0;
  bool babbling_ = false;
  int write_error_ = 0;
  std::vector<canfd_frame> written_;
};

}  // namespace dwell::test
