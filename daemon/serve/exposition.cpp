#include "daemon/serve/exposition.hpp"

#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

namespace dwell {
namespace {

// A label's value and a JSON string escape the quote, the backslash and the line end alike. Other control characters
// have no escape in a label's value; they become blanks.
std::string label_text(std::string_view value) {
  std::string clean(value);
  for (char& c : clean)
    if (static_cast<unsigned char>(c) < 0x20 && c != '\n') c = ' ';
  return nlohmann::json(clean).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// The shortest text that is read as the same number.
std::string shortest_text(double value) {
  char text[32];
  const auto [end, error] = std::to_chars(text, text + sizeof text, value);
  return error == std::errc() ? std::string(text, end) : "NaN";
}

}  // namespace

void Exposition::begin(std::string_view name, std::string_view type, std::string_view help) {
  name_ = name;
  head_ = "# HELP ";
  head_.append(name).append(" ").append(help).append("\n# TYPE ").append(name).append(" ").append(type).append("\n");
}

void Exposition::sample(double value, const Labels& labels) {
  if (!std::isfinite(value)) return;
  text_.append(head_);
  head_.clear();
  text_.append(name_);
  char before = '{';
  for (const auto& [label, text] : labels) {
    (text_ += before).append(label).append("=").append(label_text(text));
    before = ',';
  }
  if (!labels.empty()) text_ += '}';
  text_.append(" ").append(shortest_text(value)).append("\n");
}

}  // namespace dwell
