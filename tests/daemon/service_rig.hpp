// A simulated rig over Modbus TCP and the rig file that goes with it, for the tests of the whole service.
#pragma once

#include <chrono>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "tests/daemon/sockets.hpp"
#include "tests/rigsim/server.hpp"

namespace dwell::test {

inline rigsim::Options clamped_rig(std::uint16_t port = 0) {
  rigsim::Options options;
  options.tcp_port = port;
  options.faults.noise = 1e-3;
  options.seed = 7;
  return options;
}

// Of the rig above; the service listens on a port of the kernel's choice.
inline std::string rig_file(std::uint16_t device_port) {
  std::string text = R"([rig]
name     = "simulated"
motion   = "translation"
boundary = "clamped"
masses   = [12.0, 8.0, 5.0]
[excitation]
frequency = 4.0
minimum   = 2e-5
[server]
listen = "127.0.0.1:0"
[[device]]
name      = "amplifier"
driver    = "modbus"
transport = "tcp"
host      = "127.0.0.1"
port      = )" + std::to_string(device_port) +
                     R"(
rate      = 200
timeout   = 0.1
)";
  const auto channel = [&text](const char* name, const char* measures, const char* at, const char* unit, int value) {
    text.append("[[channel]]\nname = \"").append(name).append("\"\ndevice = \"amplifier\"\nmeasures = \"");
    text.append(measures).append("\"\nat = ").append(at).append("\nunit = \"").append(unit);
    text.append("\"\nstation = 1\ntable = \"input\"\ntype = \"float32\"\norder = \"abcd\"\nregister = ");
    text.append(std::to_string(2 * value)).append("\n");
  };
  channel("y0", "displacement", "0", "m", 0);
  channel("y1", "displacement", "1", "m", 1);
  channel("y2", "displacement", "2", "m", 2);
  channel("y3", "displacement", "3", "m", 3);
  channel("reaction", "force", "\"ground\"", "N", 4);
  return text;
}

inline nlohmann::json get_json(std::uint16_t port, const std::string& path) {
  return nlohmann::json::parse(get(port, path).body, nullptr, false);
}

// Asks until `enough` says so; the last answer. Patience, not a measure of speed: a machine may be slow.
inline nlohmann::json await(std::uint16_t port, const std::string& path,
                            const std::function<bool(const nlohmann::json&)>& enough) {
  nlohmann::json answer;
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  while (std::chrono::steady_clock::now() < end) {
    answer = get_json(port, path);
    if (answer.is_object() && enough(answer)) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return answer;
}

inline bool all_channels(const nlohmann::json& answer, const std::string& status) {
  for (const auto& channel : answer["channels"])
    if (channel["status"] != status) return false;
  return !answer["channels"].empty();
}

}  // namespace dwell::test
