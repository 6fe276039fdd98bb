#include "daemon/serve/query.hpp"

#include <algorithm>

#include "daemon/serve/next_part.hpp"

namespace dwell {
namespace {

constexpr std::string_view kHexDigits = "0123456789ABCDEF";

int hex_value(char c) {
  const auto at = kHexDigits.find(c >= 'a' && c <= 'f' ? static_cast<char>(c - ('a' - 'A')) : c);
  return at == std::string_view::npos ? -1 : static_cast<int>(at);
}

bool stands_for_itself(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view("-._~").find(c) != std::string_view::npos;
}

std::string expectation(const std::vector<QueryKey>& keys) {
  if (keys.empty()) return "expected no query here";
  std::string text = "expected ";
  for (const QueryKey& key : keys) text += (&key == keys.data() ? "" : ", ") + key.expected;
  return text + (keys.size() > 1 ? ", or several joined by &" : "");
}

}  // namespace

std::optional<std::string> query_fault(std::string_view query, const std::vector<QueryKey>& keys) {
  std::vector<const QueryKey*> given;
  while (!query.empty()) {
    const std::string_view term = next_part(query, '&');
    std::string_view value = term;
    const std::string_view name = next_part(value, '=');
    const auto key = std::find_if(keys.begin(), keys.end(), [&](const QueryKey& k) { return k.name == name; });
    const bool known = key != keys.end();
    const bool again = known && std::find(given.begin(), given.end(), &*key) != given.end();
    if (known && !again && key->take(value)) {
      given.push_back(&*key);
      continue;
    }
    return "\"" + std::string(term) +
           "\" is not understood: " + (again ? std::string(name) + " is given twice; " : "") + expectation(keys);
  }
  return std::nullopt;
}

std::string percent_decoded(std::string_view text) {
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool code =
        text[i] == '%' && i + 2 < text.size() && hex_value(text[i + 1]) >= 0 && hex_value(text[i + 2]) >= 0;
    bytes += code ? static_cast<char>(16 * hex_value(text[i + 1]) + hex_value(text[i + 2])) : text[i];
    if (code) i += 2;
  }
  return bytes;
}

std::string percent_encoded(std::string_view text) {
  std::string coded;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (stands_for_itself(c))
      coded += c;
    else
      ((coded += '%') += kHexDigits[byte / 16]) += kHexDigits[byte % 16];
  }
  return coded;
}

}  // namespace dwell
