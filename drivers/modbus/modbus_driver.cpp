// The modbus plugin: Modbus TCP and RTU by libmodbus.
#include <cmath>
#include <vector>

#include "drivers/dwell_driver.hpp"
#include "drivers/modbus/link.hpp"
#include "drivers/modbus/poller.hpp"
#include "drivers/modbus/setup.hpp"

namespace dwell::modbus {
namespace {

class ModbusDriver {
 public:
  ModbusDriver(const driver::Settings& settings, const driver::Host& host) : poller_(read_setup(settings), host) {}

  void run(driver::Stop& stop) { poller_.run(stop); }

  static void check(const driver::Settings& settings, driver::Report& report) { check_setup(settings, report); }

  static void describe(const driver::Settings& settings, dwell_traits& traits) {
    const Setup setup = read_setup(settings);
    traits.rate_may_shift = settings.get<bool>("rate_shift", true) ? 1 : 0;
    traits.rate_hz = setup.rate_hz;
    traits.age_ns = greatest_age_ns(setup);
    traits.most_rate_hz = most_rate_hz(setup);
  }

  static void probe(const driver::Settings& settings, driver::Probed& probed) {
    const Setup setup = read_setup(settings);
    const driver::Stop never(nullptr);
    Link link(setup);
    std::vector<std::uint16_t> registers(kMaxRegisters);
    std::string error = link.open(never);
    // A station that did not answer once is not waited for again.
    std::vector<std::string> dead(256);
    for (const Block& block : setup.blocks) {
      Answer answer;
      std::string why = error.empty() ? dead[block.station] : error;
      if (why.empty()) {
        answer = link.read(block, registers.data(), never);
        if (answer.fault != DWELL_FAULT_NONE) why = reason_of(answer, block, setup);
        if (answer.fault == DWELL_FAULT_TIMEOUT) dead[block.station] = why;
        if (answer.broken) {
          link.close();
          error = link.open(never);
        }
      }
      for (const Reading& reading : block.readings) {
        const std::size_t position = position_of(settings, reading.index);
        const double value =
            decode(&registers[reading.first - static_cast<unsigned>(block.first)], reading.type, reading.order);
        if (!why.empty())
          probed.error(position, why);
        else if (!std::isfinite(value))
          probed.error(position, "the device answers with what is not a finite number");
        else
          probed.value(position, value, answer.received_ns - answer.sent_ns);
      }
    }
  }

 private:
  static std::size_t position_of(const driver::Settings& settings, std::uint16_t index) {
    std::size_t position = 0;
    while (settings.channels()[position].index != index) ++position;
    return position;
  }

  Poller poller_;
};

}  // namespace
}  // namespace dwell::modbus

DWELL_DRIVER(dwell::modbus::ModbusDriver, "modbus", "1.0.0", "Modbus TCP and RTU", dwell::modbus::keys())
