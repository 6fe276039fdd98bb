// The study's table: what was to be reached, what was, on how many dwells.
#pragma once

#include <string>
#include <vector>

namespace dwell::study {

struct Row {
  std::string figure, reached, target;
  long count = 0;  // dwells (elements, steps, hours: the figure says) behind it
  bool met = false;
};

[[nodiscard]] std::string text(const char* format, ...) __attribute__((format(printf, 1, 2)));

void print(const std::vector<Row>& rows);

}  // namespace dwell::study
