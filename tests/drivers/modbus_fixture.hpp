// What the tests of the modbus plugin share.
#pragma once

#include <string>
#include <vector>

#include "daemon/acquire/plugin.hpp"
#include "tests/drivers/fake_host.hpp"
#include "tests/drivers/given.hpp"
#include "tests/drivers/modbus_device.hpp"

namespace dwell::test {

inline constexpr auto kTcp = ModbusDevice::Over::tcp;
inline constexpr auto kSerial = ModbusDevice::Over::serial;

inline const dwell_driver_table& driver_table() { return *acquire::load_plugin("modbus", {TEST_PLUGIN_DIR}).value(); }

inline Given over_tcp(const ModbusDevice& device) {
  Given given("amplifier");
  given.set("transport", "tcp").set("host", "127.0.0.1").set("port", device.port()).set("rate", 200.0);
  return given;
}

inline Given over_serial(const ModbusDevice& device) {
  Given given("line");
  given.set("transport", "rtu").set("serial", device.serial()).set("baud", 115200).set("rate", 50.0);
  return given;
}

inline Given& add_word(Given& given, const std::string& name, int first, int station = 1) {
  return given.channel(name).set("station", station).set("register", first).set("type", "uint16");
}

inline std::uint16_t register_number(unsigned r) { return static_cast<std::uint16_t>(r); }
inline std::vector<Reply> honest(const Request& request) { return {answer(request, register_number)}; }

}  // namespace dwell::test
