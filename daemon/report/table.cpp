#include "daemon/report/table.hpp"

#include <algorithm>
#include <utility>

#include "daemon/report/number_text.hpp"

namespace dwell {
namespace {

constexpr std::size_t kBetween = 2;  // blanks between columns

}  // namespace

void Table::add(const std::string& title, std::vector<std::string> cells, Align align, bool with_previous) {
  for (std::string& cell : cells) cell = printable(cell);
  columns_.push_back({printable(title), std::move(cells), align, with_previous});
}

std::size_t Table::rows() const {
  std::size_t rows = 0;
  for (const Column& column : columns_) rows = std::max(rows, column.cells.size());
  return rows;
}

std::size_t Table::width_of(const Column& column) {
  std::size_t columns = width(column.title);
  for (const std::string& cell : column.cells) columns = std::max(columns, width(cell));
  return columns;
}

Section Table::section(const std::vector<const Column*>& columns) const {
  std::vector<TextLine> lines(rows() + 1);
  for (const Column* column : columns) {
    const std::size_t wide = width_of(*column);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::string empty;
      const std::string& cell = i == 0 ? column->title : i <= column->cells.size() ? column->cells[i - 1] : empty;
      lines[i].text += column->align == Align::right ? pad_left(cell, wide) : pad_right(cell, wide);
      lines[i].text.append(kBetween, ' ');
    }
  }
  for (TextLine& line : lines) line.text.erase(line.text.find_last_not_of(' ') + 1);
  for (std::size_t i = 1; i < lines.size() && i <= styles_.size(); ++i) lines[i].style = styles_[i - 1];
  lines.front().style = Style::title;
  Section section;
  section.head.push_back(std::move(lines.front()));
  section.body.assign(std::make_move_iterator(lines.begin() + 1), std::make_move_iterator(lines.end()));
  return section;
}

std::vector<Section> Table::sections(std::size_t columns) const {
  std::vector<Section> sections;
  if (rows() == 0) return sections;
  std::vector<const Column*> taken{&columns_.front()};
  const std::size_t key_width = width_of(columns_.front());
  std::size_t used = key_width;
  for (std::size_t i = 1; i < columns_.size();) {
    // A column and those that belong to it, or the column alone where not even an empty table has room for them.
    std::size_t end = i;
    std::size_t wide = 0;
    do wide += kBetween + width_of(columns_[end++]);
    while (end < columns_.size() && columns_[end].with_previous);
    if (end > i + 1 && wide > columns - std::min(columns, key_width)) {
      end = i + 1;
      wide = kBetween + width_of(columns_[i]);
    }
    if (taken.size() > 1 && wide > columns - std::min(columns, used)) {
      sections.push_back(section(taken));
      taken = {&columns_.front()};
      used = key_width;
    }
    for (; i < end; ++i) taken.push_back(&columns_[i]);
    used += wide;
  }
  sections.push_back(section(taken));
  return sections;
}

std::string Table::text() const { return plain_text(sections(kUnlimited)); }

}  // namespace dwell
