// HTML text, a piece at a time. Whatever comes from outside (labels, names, reasons) is escaped here and nowhere else.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dwell::handon {

// Text as it may stand between tags and in quoted attributes. Control characters but newline and tab, and bytes that
// are not UTF-8, become U+FFFD.
[[nodiscard]] std::string escaped(std::string_view text);

// A cell or paragraph: either text, which is escaped, or markup made here.
class Markup {
 public:
  Markup(const std::string& text) : html_(escaped(text)) {}  // NOLINT(google-explicit-constructor): cells are text
  Markup(const char* text) : html_(escaped(text)) {}         // NOLINT(google-explicit-constructor)
  [[nodiscard]] static Markup made(std::string html);
  [[nodiscard]] const std::string& html() const noexcept { return html_; }

 private:
  Markup() = default;
  std::string html_;
};

struct Column {
  std::string title;
  bool number = false;  // aligned to the right, never broken
  bool whole = false;   // never broken: instants and single words
};

// <table> with a head; rows may be shorter than the columns.
[[nodiscard]] std::string html_table(const std::vector<Column>& columns, const std::vector<std::vector<Markup>>& rows);
// Two columns without a head: what, and its value. A row whose value is empty is left out.
[[nodiscard]] std::string html_facts(const std::vector<std::pair<std::string, Markup>>& facts);
[[nodiscard]] std::string html_heading(int level, const Markup& text);
[[nodiscard]] std::string html_paragraph(const Markup& text, std::string_view css_class = {});
// <ul>; empty: nothing.
[[nodiscard]] std::string html_list(const std::vector<std::string>& items, std::string_view css_class = {});

}  // namespace dwell::handon
