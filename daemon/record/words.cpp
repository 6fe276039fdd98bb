#include "daemon/record/words.hpp"

#include "core/base/printable.hpp"
#include "daemon/record/utf8.hpp"

namespace dwell::record {

std::string why_not_words(std::string_view text, std::size_t most) {
  if (text.size() > most)
    return "it has " + std::to_string(text.size()) + " bytes, expected at most " + std::to_string(most);
  if (std::string why = why_not_utf8(text); !why.empty()) return why;
  if (!text.empty() && text.find_first_not_of(' ') == std::string_view::npos)
    return "it holds only spaces, expected words";
  if (has_control(text)) return "it holds a control character, expected one line of plain text";
  return {};
}

}  // namespace dwell::record
