// The study's table: what was to be reached, what was, on how many dwells.
#pragma once

#include <string>
#include <vector>

namespace dwell::study {

struct Row {
  std::string figure, reached, target;
  long count = 0;  // dwells (elements, steps, hours: the figure says) behind it
  bool met = false;
  double value = 0.0;  // `reached` as a number
  double cost = 0.0;   // grows as the figure gets worse; within a target that is a range: 0
};

[[nodiscard]] std::string text(const char* format, ...) __attribute__((format(printf, 1, 2)));

void print(const std::vector<Row>& rows);

}  // namespace dwell::study
