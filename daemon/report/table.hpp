// A table of text cells for a terminal: columns line up under UTF-8, no trailing blanks, two blanks between columns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "daemon/report/line.hpp"

namespace dwell {

enum class Align : std::uint8_t { left, right };

class Table {
 public:
  struct Column {
    std::string title;
    std::vector<std::string> cells;
    Align align = Align::left;
    bool with_previous = false;
  };

  // Columns may differ in length; missing cells are empty. Cells are shown without control characters.
  // with_previous: the column means nothing without the one before it, and stays beside it where the table is broken.
  void add(const std::string& title, std::vector<std::string> cells, Align align = Align::left,
           bool with_previous = false);

  // How the rows look; rows beyond are plain.
  void set_styles(std::vector<Style> styles) { styles_ = std::move(styles); }

  // The table broken into as many tables below each other as its columns need to fit into `columns`, each beginning
  // with the first column. One that is too wide alone is not broken further. Empty if there are no cells at all.
  [[nodiscard]] std::vector<Section> sections(std::size_t columns) const;

  // Lines, each with its end; the titles first. Empty if there are no cells at all.
  [[nodiscard]] std::string text() const;

 private:
  [[nodiscard]] std::size_t rows() const;
  [[nodiscard]] static std::size_t width_of(const Column& column);
  [[nodiscard]] Section section(const std::vector<const Column*>& columns) const;

  std::vector<Column> columns_;
  std::vector<Style> styles_;
};

}  // namespace dwell
