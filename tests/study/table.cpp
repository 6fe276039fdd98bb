#include "tests/study/table.hpp"

#include <algorithm>
#include <cstdarg>
#include <cstdio>

namespace dwell::study {
namespace {

// Columns on a terminal, a multi-byte character being one.
std::size_t width(const std::string& s) {
  return static_cast<std::size_t>(std::count_if(s.begin(), s.end(), [](char c) { return (c & 0xc0) != 0x80; }));
}

}  // namespace

std::string text(const char* format, ...) {
  char buffer[512];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

void print(const std::vector<Row>& rows) {
  std::vector<std::vector<std::string>> cells{{"figure", "reached", "target", "of", "met"}};
  for (const Row& row : rows)
    cells.push_back({row.figure, row.reached, row.target, std::to_string(row.count), row.met ? "yes" : "NO"});
  std::vector<std::size_t> widths(cells[0].size());
  for (const auto& line : cells)
    for (std::size_t i = 0; i < line.size(); ++i) widths[i] = std::max(widths[i], width(line[i]));
  for (std::size_t l = 0; l < cells.size(); ++l) {
    std::string out = "|";
    for (std::size_t i = 0; i < cells[l].size(); ++i)
      out += " " + cells[l][i] + std::string(widths[i] - width(cells[l][i]), ' ') + " |";
    std::puts(out.c_str());
    if (l > 0) continue;
    out = "|";
    for (const std::size_t w : widths) out += std::string(w + 2, '-') + "|";
    std::puts(out.c_str());
  }
}

}  // namespace dwell::study
