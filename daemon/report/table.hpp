// A table of text cells for a terminal: columns line up under UTF-8, no trailing blanks, two blanks between columns.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace dwell {

enum class Align : std::uint8_t { left, right };

class Table {
 public:
  struct Column {
    std::string title;
    std::vector<std::string> cells;
    Align align = Align::left;
  };

  // Columns may differ in length; missing cells are empty. Cells are shown without control characters.
  void add(const std::string& title, std::vector<std::string> cells, Align align = Align::left);

  // Lines, each with its end; the titles first. Empty if there are no cells at all.
  [[nodiscard]] std::string text() const;

 private:
  std::vector<Column> columns_;
};

}  // namespace dwell
