#include "daemon/handon/html.hpp"

#include <cstddef>
#include <utility>

#include "core/base/printable.hpp"

namespace dwell::handon {
namespace {

constexpr const char* kReplacement = "\xEF\xBF\xBD";

// Bytes of the UTF-8 character at the beginning of `text`; 0: it is invalid, or must not be shown.
std::size_t character(std::string_view text) {
  const auto byte = [&text](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
  const unsigned first = byte(0);
  if (first < 0x80) return first >= 0x20 && first != 0x7F ? 1 : (first == '\n' || first == '\t') ? 1 : 0;
  const std::size_t length = first >= 0xF0 ? 4 : first >= 0xE0 ? 3 : 2;
  if (first < 0xC2 || first > 0xF4) return 0;
  unsigned code = first & (0xFFU >> (length + 1));
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0U) != 0x80U) return 0;
    code = (code << 6U) | (byte(i) & 0x3FU);
  }
  constexpr unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool control = code < 0xA0 || code == 0xFFFE || code == 0xFFFF;
  const bool valid = code >= least[length] && code <= 0x10FFFF && (code < 0xD800 || code > 0xDFFF);
  return valid && !control && !turns_text(code) ? length : 0;
}

std::string open_tag(std::string_view tag, std::string_view css_class) {
  std::string text = "<" + std::string(tag);
  if (!css_class.empty()) text.append(" class=\"").append(css_class).append("\"");
  return text + ">";
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string html;
  html.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = character(text);
    if (length == 0) {
      html += kReplacement;
      text.remove_prefix(1);
      continue;
    }
    switch (text.front()) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      case '\'':
        html += "&#39;";
        break;
      default:
        html.append(text.substr(0, length));
    }
    text.remove_prefix(length);
  }
  return html;
}

Markup Markup::made(std::string html) {
  Markup markup;
  markup.html_ = std::move(html);
  return markup;
}

std::string html_table(const std::vector<Column>& columns, const std::vector<std::vector<Markup>>& rows) {
  const auto cell = [&columns](const char* tag, std::size_t i, const std::string& html) {
    const bool known = i < columns.size();
    return open_tag(tag, known && columns[i].number  ? "number"
                         : known && columns[i].whole ? "whole"
                                                     : "") +
           html + "</" + tag + ">";
  };
  std::string html = "<table><thead><tr>";
  for (std::size_t i = 0; i < columns.size(); ++i) html += cell("th", i, escaped(columns[i].title));
  html += "</tr></thead><tbody>\n";
  for (const std::vector<Markup>& row : rows) {
    html += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i) html += cell("td", i, row[i].html());
    html += "</tr>\n";
  }
  return html + "</tbody></table>\n";
}

std::string html_facts(const std::vector<std::pair<std::string, Markup>>& facts) {
  std::string html = "<table class=\"facts\"><tbody>\n";
  for (const auto& [what, value] : facts)
    if (!value.html().empty())
      html.append("<tr><th>").append(escaped(what)).append("</th><td>").append(value.html()).append("</td></tr>\n");
  return html + "</tbody></table>\n";
}

std::string html_heading(int level, const Markup& text) {
  const std::string tag = "h" + std::to_string(level);
  return "<" + tag + ">" + text.html() + "</" + tag + ">\n";
}

std::string html_paragraph(const Markup& text, std::string_view css_class) {
  return open_tag("p", css_class) + text.html() + "</p>\n";
}

std::string html_list(const std::vector<std::string>& items, std::string_view css_class) {
  if (items.empty()) return {};
  std::string html = open_tag("ul", css_class);
  for (const std::string& item : items) html.append("<li>").append(escaped(item)).append("</li>");
  return html + "</ul>\n";
}

}  // namespace dwell::handon
