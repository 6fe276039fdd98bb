// What an engineer would otherwise script: wait a fixed time, take a block of every channel as if all were sampled at
// once and evenly, transform it, divide.
#pragma once

#include <vector>

#include "tests/study/case.hpp"

namespace dwell::study {

struct Script {
  double answer_s = 0.0;   // when the block is full
  std::vector<Complex> Z;  // per element
};

[[nodiscard]] Script run_script(const Case& about);

}  // namespace dwell::study
