#include "tests/drivers/canopen_device.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <vector>

#include "tests/drivers/fake_host.hpp"
#include "tests/rigsim/can_wire.hpp"
#include "tests/rigsim/canopen_node.hpp"

namespace dwell::test {

CanopenDevice::CanopenDevice(const std::string& interface) : interface_(interface) {
  static std::atomic<int> number{0};
  const auto name = "dwell-canopen-" + std::to_string(::getpid()) + "-" + std::to_string(++number);
  if (interface_.empty()) interface_ = "unix:" + (std::filesystem::temp_directory_path() / name).string();
  thread_ = std::thread([this] { work(); });
}

CanopenDevice::~CanopenDevice() {
  ending_ = true;
  thread_.join();
}

void CanopenDevice::come() {
  silent_ = false;
  present_ = true;
  eventually([this] { return listening_.load(); });
}

void CanopenDevice::leave() {
  present_ = false;
  eventually([this] { return !listening_; });
}

void CanopenDevice::work() {
  std::optional<rigsim::CanWire> wire;
  std::vector<can_frame> out;
  rigsim::CanopenNode node(kNode, rigsim::Transducer::input, out);
  std::vector<rigsim::WireFrame> received;
  while (!ending_) {
    if (!present_) wire.reset();
    if (present_ && !wire) {
      if (auto opened = rigsim::CanWire::open(interface_)) {
        wire = std::move(*opened);
        node.reset(driver::monotonic_ns());
      }
    }
    listening_ = wire.has_value();
    std::vector<pollfd> polled;
    if (wire) wire->watch(polled);
    ::poll(polled.data(), polled.size(), 1);
    if (!wire) continue;
    received.clear();
    wire->receive(received);
    const std::int64_t now_ns = driver::monotonic_ns();
    node.tick(now_ns);
    for (const rigsim::WireFrame& each : received) {
      can_frame frame{};
      frame.can_id = each.can.can_id;
      frame.can_dlc = each.can.len;
      std::copy_n(each.can.data, CAN_MAX_DLEN, frame.data);
      node.set_value(2e-9);
      node.set_entry(0x6150, 1, 1, 1, false);
      if (frame.can_id == 0x80) node.sync(2e-9);
      node.take(frame, now_ns);
    }
    for (const can_frame& each : out) {
      rigsim::WireFrame frame;
      frame.can.can_id = each.can_id;
      frame.can.len = each.can_dlc;
      std::copy_n(each.data, CAN_MAX_DLEN, frame.can.data);
      if (!silent_) wire->send(frame);
    }
    out.clear();
  }
}

}  // namespace dwell::test
