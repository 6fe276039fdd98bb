#include "daemon/report/table.hpp"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "daemon/report/number_text.hpp"

namespace dwell {

void Table::add(const std::string& title, std::vector<std::string> cells, Align align) {
  for (std::string& cell : cells) cell = printable(cell);
  columns_.push_back({printable(title), std::move(cells), align});
}

std::string Table::text() const {
  std::size_t rows = 0;
  for (const Column& column : columns_) rows = std::max(rows, column.cells.size());
  if (rows == 0) return {};
  std::vector<std::string> lines(rows + 1);
  for (const Column& column : columns_) {
    std::size_t columns = width(column.title);
    for (const std::string& cell : column.cells) columns = std::max(columns, width(cell));
    for (std::size_t i = 0; i <= rows; ++i) {
      const std::string empty;
      const std::string& cell = i == 0 ? column.title : i <= column.cells.size() ? column.cells[i - 1] : empty;
      lines[i] += column.align == Align::right ? pad_left(cell, columns) : pad_right(cell, columns);
      lines[i] += "  ";
    }
  }
  std::string text;
  for (std::string& line : lines) {
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

}  // namespace dwell
