// A Modbus device that does as a script says, over TCP or over a pseudo-terminal: answers, keeps silent, lies.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace dwell::test {

struct Request {
  int number = 0;  // 0, 1, … since the device came
  std::uint16_t transaction = 0;
  std::uint8_t unit = 0;
  std::uint8_t function = 0;
  std::uint16_t first = 0;
  std::uint16_t count = 0;
};

// One thing the device sends after a request.
struct Reply {
  std::vector<std::uint8_t> pdu;             // function code and what follows
  std::chrono::milliseconds delay{0};        // before it is sent
  std::optional<std::uint16_t> transaction;  // other than the request's
  std::optional<std::uint8_t> unit;
  bool bad_checksum = false;
  std::size_t keep = 1000;  // bytes of the frame that are sent
  bool reset = false;       // instead: drop the connection
};

using Script = std::function<std::vector<Reply>(const Request&)>;

// The answer of a device whose register r holds value_of(r).
Reply answer(const Request& request, const std::function<std::uint16_t(unsigned)>& value_of);
Reply exception(const Request& request, std::uint8_t code);

class ModbusDevice {
 public:
  enum class Over : std::uint8_t { tcp, serial };

  ModbusDevice(Over over, Script script);
  ~ModbusDevice();
  ModbusDevice(const ModbusDevice&) = delete;
  ModbusDevice& operator=(const ModbusDevice&) = delete;

  // Switches it off and on again; where it is found stays the same. Begins on.
  void leave();
  void come();

  int port() const { return port_; }
  const std::string& serial() const { return serial_; }
  int requests() const { return requests_; }

 private:
  void serve_tcp();
  void serve_serial();
  // false: drop the connection.
  bool respond(int descriptor, const Request& request);

  Over over_;
  Script script_;
  int port_ = 0;
  std::string serial_;
  int listener_ = -1;  // tcp
  int master_ = -1;    // serial
  int slave_ = -1;     // serial: kept open, so that the master never sees a hang-up
  std::atomic<bool> leaving_{false};
  std::atomic<int> requests_{0};
  std::thread thread_;
};

}  // namespace dwell::test
