// A CANopen bus with one node, for tests: on a local socket or a CAN interface, from a thread of its own. The node
// (number 3) is rigsim's input: 6150h:01 (8 bits) reads 1, 9130h:01 (32 bits) reads 2.
#pragma once

#include <atomic>
#include <string>
#include <thread>

namespace dwell::test {

class CanopenDevice {
 public:
  static constexpr int kNode = 3;

  // Begins absent. Empty: a local socket.
  explicit CanopenDevice(const std::string& interface = "");
  ~CanopenDevice();
  CanopenDevice(const CanopenDevice&) = delete;
  CanopenDevice& operator=(const CanopenDevice&) = delete;

  [[nodiscard]] const std::string& interface() const { return interface_; }
  // Both return when it is done.
  void come();
  void leave();
  void set_silent(bool silent) { silent_ = silent; }

 private:
  void work();

  std::string interface_;
  std::atomic<bool> present_{false}, listening_{false}, silent_{false}, ending_{false};
  std::thread thread_;
};

}  // namespace dwell::test
