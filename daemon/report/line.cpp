#include "daemon/report/line.hpp"

#include <algorithm>

#include "daemon/report/number_text.hpp"

namespace dwell {
namespace {

// The byte at which the code point number `count` of a text begins; its size if there are no more.
std::size_t bytes_of(std::string_view text, std::size_t count) {
  std::size_t points = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool begins = (static_cast<unsigned char>(text[i]) & 0xC0U) != 0x80U;
    if (begins && points++ == count) return i;
  }
  return text.size();
}

}  // namespace

std::string clipped(std::string_view text, std::size_t columns) {
  if (width(text) <= columns) return std::string(text);
  if (columns == 0) return {};
  return std::string(text.substr(0, bytes_of(text, columns - 1))) + "…";
}

std::vector<std::string> wrapped(std::string_view text, std::size_t columns, std::size_t indent) {
  std::vector<std::string> lines;
  std::size_t room = std::max<std::size_t>(columns, 8);
  // Looks at one line's bytes at a time: a width of all that is left would cost the square of a text's length.
  for (std::size_t most = 0; (most = bytes_of(text, room)) < text.size();) {
    // A blank right behind the last code point that fits is a good place, too.
    const std::size_t blank = text.substr(0, most + 1).find_last_of(' ');
    const bool at_blank = blank != std::string_view::npos && blank > 0;
    lines.push_back((lines.empty() ? "" : std::string(indent, ' ')) +
                    std::string(text.substr(0, at_blank ? blank : most)));
    text.remove_prefix(at_blank ? blank + 1 : most);
    if (lines.size() == 1) {
      indent = std::min(indent, room - 8);
      room -= indent;
    }
  }
  lines.push_back((lines.empty() ? "" : std::string(indent, ' ')) + std::string(text));
  return lines;
}

std::string plain_text(const std::vector<Section>& sections) {
  std::string text;
  for (const Section& section : sections) {
    if (!text.empty()) text += "\n";
    for (const TextLine& line : section.head) text += line.text + "\n";
    for (const TextLine& line : section.body) text += line.text + "\n";
  }
  return text;
}

}  // namespace dwell
