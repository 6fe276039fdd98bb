#include "drivers/modbus/plan.hpp"

#include <algorithm>
#include <tuple>

namespace dwell::modbus {

std::vector<Block> plan(std::vector<Reading> readings, unsigned max_registers) {
  std::stable_sort(readings.begin(), readings.end(), [](const Reading& a, const Reading& b) {
    return std::tie(a.station, a.table, a.first) < std::tie(b.station, b.table, b.first);
  });
  std::vector<Block> blocks;
  for (const Reading& reading : readings) {
    if (!blocks.empty()) {
      Block& last = blocks.back();
      const unsigned end = std::max(last.end(), reading.end());
      if (last.station == reading.station && last.table == reading.table && reading.first <= last.end() &&
          end - last.first <= max_registers) {
        last.count = static_cast<std::uint16_t>(end - last.first);
        last.readings.push_back(reading);
        continue;
      }
    }
    blocks.push_back({reading.station,
                      reading.table,
                      reading.first,
                      static_cast<std::uint16_t>(registers_of(reading.type)),
                      {reading}});
  }
  return blocks;
}

}  // namespace dwell::modbus
