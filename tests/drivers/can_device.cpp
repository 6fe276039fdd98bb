#include "tests/drivers/can_device.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "tests/drivers/fake_host.hpp"

namespace dwell::test {

rigsim::WireFrame can_frame_of(canid_t id, const std::vector<std::uint8_t>& data) {
  rigsim::WireFrame frame;
  frame.can.can_id = id;
  frame.can.len = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), frame.can.data);
  frame.fd = data.size() > CAN_MAX_DLEN;
  return frame;
}

CanDevice::CanDevice(Frames cyclic, std::string interface)
    : cyclic_(std::move(cyclic)), interface_(std::move(interface)) {
  static std::atomic<int> number{0};
  const auto name = "dwell-can-" + std::to_string(::getpid()) + "-" + std::to_string(++number);
  if (interface_.empty()) interface_ = "unix:" + (std::filesystem::temp_directory_path() / name).string();
  thread_ = std::thread([this] { work(); });
}

CanDevice::~CanDevice() {
  ending_ = true;
  thread_.join();
}

void CanDevice::come() {
  silent_ = false;
  present_ = true;
  eventually([this] { return listening_.load(); });
}

void CanDevice::leave() {
  present_ = false;
  eventually([this] { return !listening_; });
}

bool CanDevice::await_client() const {
  return eventually([this] { return clients_ > 0; });
}

void CanDevice::send(const rigsim::WireFrame& frame) {
  const std::lock_guard lock(mutex_);
  to_send_.push_back(frame);
}

std::vector<rigsim::WireFrame> CanDevice::received() const {
  const std::lock_guard lock(mutex_);
  return received_;
}

void CanDevice::work() {
  std::optional<rigsim::CanWire> wire;
  for (std::int64_t next_ns = driver::monotonic_ns(); !ending_; next_ns += 1'000'000) {
    if (!present_) wire.reset();
    if (present_ && !wire)
      if (auto opened = rigsim::CanWire::open(interface_)) wire = std::move(*opened);
    if (wire) {
      const std::lock_guard lock(mutex_);
      wire->receive(received_);
      for (const rigsim::WireFrame& frame : to_send_) wire->send(frame);
      to_send_.clear();
      if (cyclic_ && !silent_ && next_ns / 1'000'000 % 5 == 0)
        for (const rigsim::WireFrame& frame : cyclic_()) wire->send(frame);
    }
    listening_ = wire.has_value();
    clients_ = wire ? wire->clients() : 0;
    std::this_thread::sleep_for(std::chrono::nanoseconds(std::max<std::int64_t>(0, next_ns - driver::monotonic_ns())));
  }
}

namespace {

bool ip_link(const std::string& what) { return std::system(("ip link " + what + " >/dev/null 2>&1").c_str()) == 0; }

}  // namespace

VirtualCan::VirtualCan() {
  static std::atomic<int> number{0};
  name_ = "vc" + std::to_string(::getpid() % 1'000'000) + "x" + std::to_string(++number % 1000);
}

bool VirtualCan::possible() {
  static const bool made = VirtualCan().come();
  return made;
}

bool VirtualCan::come() {
  there_ = there_ || ip_link("add " + name_ + " type vcan");
  return there_ && ip_link("set " + name_ + " mtu 72 up");
}

void VirtualCan::leave() {
  if (there_) ip_link("delete " + name_);
  there_ = false;
}

}  // namespace dwell::test
