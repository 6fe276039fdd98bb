// A CAN bus with one node, for tests: a local socket that sends what it is told, at 200 frames a second or by hand.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "tests/rigsim/can_wire.hpp"

namespace dwell::test {

// A frame of 8 bytes or fewer; with more it is a CAN FD one.
rigsim::WireFrame can_frame_of(canid_t id, const std::vector<std::uint8_t>& data);

class CanDevice {
 public:
  using Frames = std::function<std::vector<rigsim::WireFrame>()>;

  // `cyclic`: what is sent every 5 ms, from a thread; none: nothing. `interface`: where, default a local socket of its
  // own. Begins absent.
  explicit CanDevice(Frames cyclic = {}, std::string interface = {});
  ~CanDevice();
  CanDevice(const CanDevice&) = delete;
  CanDevice& operator=(const CanDevice&) = delete;

  [[nodiscard]] const std::string& interface() const { return interface_; }
  // Both return when it is done.
  void come();
  void leave();
  void set_silent(bool silent) { silent_ = silent; }
  // Waits until somebody listens; false: nobody did.
  [[nodiscard]] bool await_client() const;
  void send(const rigsim::WireFrame& frame);
  // What clients have sent so far.
  [[nodiscard]] std::vector<rigsim::WireFrame> received() const;

 private:
  void work();

  Frames cyclic_;
  std::string interface_;
  std::atomic<bool> present_{false}, listening_{false}, silent_{false}, ending_{false};
  std::atomic<std::size_t> clients_{0};
  mutable std::mutex mutex_;
  std::vector<rigsim::WireFrame> to_send_, received_;
  std::thread thread_;
};

// A virtual CAN interface of the kernel, of a name of its own; there from come() to leave().
class VirtualCan {
 public:
  VirtualCan();
  ~VirtualCan() { leave(); }
  VirtualCan(const VirtualCan&) = delete;
  VirtualCan& operator=(const VirtualCan&) = delete;

  // Whether this process can make one: it needs a kernel with vcan and the right to.
  [[nodiscard]] static bool possible();
  [[nodiscard]] const std::string& name() const { return name_; }
  bool come();
  void leave();

 private:
  std::string name_;
  bool there_ = false;
};

}  // namespace dwell::test
