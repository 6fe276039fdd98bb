// The devices that the contract of dwell_driver.h is held against: one for each driver, some of them twice.
//
// A further driver joins with one Device class and a line in kCases.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>
#include <ostream>
#include <string>
#include <utility>

#include "tests/drivers/can_device.hpp"
#include "tests/drivers/canopen_device.hpp"
#include "tests/drivers/given.hpp"
#include "tests/drivers/modbus_device.hpp"

namespace dwell::test {

// What a driver talks to: two channels, 10 and 11, that hold 1 and 2, read or played at 100 Hz or more. Begins absent.
class Device {
 public:
  virtual ~Device() = default;
  virtual Given given() = 0;
  // A description with mistakes that only check can see, and how many.
  virtual std::pair<Given, std::size_t> given_wrong() = 0;
  virtual void come() = 0;
  virtual void leave() = 0;
  // There, but without an answer; false: cannot be.
  virtual bool fall_silent() { return false; }
  // What this machine lacks for it, or empty.
  virtual std::string lacking() { return {}; }
};

class ModbusRig : public Device {
 public:
  explicit ModbusRig(ModbusDevice::Over over)
      : over_(over), device_(over, [this](const Request& request) -> std::vector<Reply> {
          if (silent_) return {};
          return {answer(request, [](unsigned r) { return static_cast<std::uint16_t>(r + 1); })};
        }) {
    device_.leave();
  }
  Given given() override {
    Given given("device");
    if (over_ == ModbusDevice::Over::tcp)
      given.set("transport", "tcp").set("host", "127.0.0.1").set("port", device_.port());
    else
      given.set("transport", "rtu").set("serial", device_.serial()).set("baud", 115200).set("late", 0.1);
    given.set("rate", 100).set("timeout", 0.05);
    given.channel("one").set("register", 0).set("type", "uint16");
    given.channel("two").set("register", 1).set("type", "uint16");
    return given;
  }
  std::pair<Given, std::size_t> given_wrong() override {
    Given given("device");
    given.set("transport", over_ == ModbusDevice::Over::tcp ? "tcp" : "rtu");  // neither host nor serial
    given.channel("one").set("register", 65535).set("type", "float64");
    given.channel("two").set("register", 65535).set("type", "float32");
    return {std::move(given), 3};
  }
  void come() override {
    silent_ = false;
    device_.come();
  }
  void leave() override { device_.leave(); }
  bool fall_silent() override {
    silent_ = true;
    return true;
  }

 private:
  ModbusDevice::Over over_;
  std::atomic<bool> silent_{false};
  ModbusDevice device_;
};

class Recording : public Device {
 public:
  Recording() : file_(std::filesystem::temp_directory_path() / ("dwell-contract-" + std::to_string(::getpid()))) {}
  ~Recording() override { std::filesystem::remove(file_); }
  Given given() override {
    Given given("device");
    given.set("file", file_.string()).set("loop", true).channel("one").channel("two");
    return given;
  }
  std::pair<Given, std::size_t> given_wrong() override {
    Given given("device");
    given.set("file", "/nonexistent.csv").channel("one").channel("two").set("column", "one");
    return {std::move(given), 2};
  }
  void come() override { std::ofstream(file_) << "t,one,two\n0,1,2\n0.005,1,2\n"; }
  void leave() override { std::filesystem::remove(file_); }

 private:
  std::filesystem::path file_;
};

class CanRig : public Device {
 public:
  explicit CanRig(std::string interface = {})
      : device_(
            [] {
              return std::vector{can_frame_of(0x123, {1, 2})};
            },
            std::move(interface)) {}
  Given given() override {
    Given given("device");
    given.set("interface", device_.interface()).set("timeout", 0.2);
    given.channel("one").set("id", 0x123).set("start", 0).set("length", 8);
    given.channel("two").set("id", 0x123).set("start", 8).set("length", 8);
    return given;
  }
  std::pair<Given, std::size_t> given_wrong() override {
    Given given("device");
    given.set("interface", "far/too-long-for-an-interface").set("dbc", "/nonexistent.dbc");
    given.channel("one").set("id", 0x800).set("extended", false).set("start", 0).set("length", 8);
    given.channel("two").set("id", 1).set("start", 0).set("length", 33).set("type", "float");
    return {std::move(given), 4};
  }
  void come() override { device_.come(); }
  void leave() override { device_.leave(); }
  bool fall_silent() override {
    device_.set_silent(true);
    return true;
  }

 private:
  CanDevice device_;
};

class CanopenRig : public Device {
 public:
  // Empty: a local socket.
  explicit CanopenRig(const std::string& interface = "") : device_(interface) {}
  Given given() override {
    Given given("device");
    given.set("interface", device_.interface()).set("timeout", 0.3).set("rate", 100).set("heartbeat", 0.05);
    given.channel("one").set("node", CanopenDevice::kNode).set("index", 0x6150).set("sub_index", 1);
    given.set("type", "unsigned8");
    given.channel("two").set("node", CanopenDevice::kNode).set("index", 0x9130).set("sub_index", 1);
    return given;
  }
  std::pair<Given, std::size_t> given_wrong() override {
    Given given("device");
    given.set("interface", "far/too-long-for-an-interface").set("rate", 1).set("timeout", 0.1);
    given.channel("one").set("node", 1).set("index", 0x2000).set("vendor_id", 1);  // of no known type
    given.channel("two").set("node", 1).set("index", 0x9130).set("vendor_id", 2);
    return {std::move(given), 4};
  }
  void come() override { device_.come(); }
  void leave() override { device_.leave(); }
  bool fall_silent() override {
    device_.set_silent(true);
    return true;
  }

 private:
  CanopenDevice device_;
};

// The same on the kernel's own CAN: an interface that is made and removed.
template <class OnCan>
class VirtualRig : public Device {
 public:
  Given given() override { return rig_.given(); }
  std::pair<Given, std::size_t> given_wrong() override { return rig_.given_wrong(); }
  void come() override {
    EXPECT_TRUE(interface_.come());
    rig_.come();
  }
  void leave() override {
    rig_.leave();
    interface_.leave();
  }
  bool fall_silent() override { return rig_.fall_silent(); }
  std::string lacking() override {
    return VirtualCan::possible() ? "" : "a kernel with vcan, and the right to make interfaces: ./dev vm-test has both";
  }

 private:
  VirtualCan interface_;
  OnCan rig_{interface_.name()};
};

// A driver and a device for it.
struct Case {
  const char* name;
  const char* plugin;
  std::unique_ptr<Device> (*make)();
};
inline void PrintTo(const Case& each, std::ostream* out) { *out << each.name; }

inline const Case kCases[] = {
    {"ModbusTcp", "modbus", [] { return std::unique_ptr<Device>(new ModbusRig(ModbusDevice::Over::tcp)); }},
    {"ModbusRtu", "modbus", [] { return std::unique_ptr<Device>(new ModbusRig(ModbusDevice::Over::serial)); }},
    {"Can", "can", [] { return std::unique_ptr<Device>(new CanRig); }},
    {"VirtualCan", "can", [] { return std::unique_ptr<Device>(new VirtualRig<CanRig>); }},
    {"Canopen", "canopen", [] { return std::unique_ptr<Device>(new CanopenRig); }},
    {"VirtualCanopen", "canopen", [] { return std::unique_ptr<Device>(new VirtualRig<CanopenRig>); }},
    {"Replay", "replay", [] { return std::unique_ptr<Device>(new Recording); }}};

}  // namespace dwell::test
