// Sections set one below the other on pages of so many rows.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "daemon/report/line.hpp"

namespace dwell::ctl {

class Pager {
 public:
  explicit Pager(std::size_t rows) : rows_(std::max<std::size_t>(rows, 1)), pages_(1) {}

  // The page on which the section begins.
  std::size_t add(const Section& section) {
    const std::size_t between = pages_.back().empty() ? 0 : 1;
    const std::size_t kept = section.body.size() - section.notes;
    const std::size_t whole = section.head.size() + kept;
    const std::size_t room = rows_ - std::min(rows_, pages_.back().size() + between);
    // What fits on a page of its own is not torn; what does not, begins where three of its lines fit.
    if (room < std::min(whole, rows_) && (whole <= rows_ || room < section.head.size() + 3)) {
      turn();
    } else if (between != 0) {
      pages_.back().push_back({});
    }
    const std::size_t first = pages_.size() - 1;
    put(section.head);
    for (std::size_t i = 0; i < section.body.size(); ++i) {
      if (pages_.back().size() >= rows_) {
        turn();
        // A page of titles alone would go on for ever.
        if (i < kept && section.head.size() < rows_) put(section.head);
      }
      pages_.back().push_back(section.body[i]);
    }
    return first;
  }

  [[nodiscard]] const std::vector<std::vector<TextLine>>& pages() const { return pages_; }

 private:
  void turn() {
    if (!pages_.back().empty()) pages_.emplace_back();
  }
  void put(const std::vector<TextLine>& lines) {
    for (const TextLine& line : lines) {
      if (pages_.back().size() >= rows_) turn();
      pages_.back().push_back(line);
    }
  }

  std::size_t rows_;
  std::vector<std::vector<TextLine>> pages_;
};

}  // namespace dwell::ctl
