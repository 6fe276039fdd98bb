// What is wrong with the settings of a CAN driver, found by reading them.
#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/dwell_driver.hpp"

namespace dwell::socketcan {

struct Mistake {
  int channel = -1;  // position in Settings::channels(); -1: the device
  const char* key = nullptr;
  std::string text;
};

inline void tell(const std::vector<Mistake>& mistakes, driver::Report& report) {
  for (const Mistake& each : mistakes)
    if (each.channel < 0)
      report.device(each.key, each.text);
    else
      report.channel(static_cast<std::size_t>(each.channel), each.key, each.text);
}

// Throws the first, if there is one.
inline void refuse(const std::vector<Mistake>& mistakes) {
  if (!mistakes.empty()) throw std::runtime_error(mistakes.front().text);
}

}  // namespace dwell::socketcan
