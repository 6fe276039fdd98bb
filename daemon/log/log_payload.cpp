#include "daemon/log/log_payload.hpp"

namespace dwell {
namespace {

void append_printable(std::string& to, std::string_view text) {
  for (const char c : text) to.push_back(static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c);
}

}  // namespace

std::string make_payload(std::string_view message, std::initializer_list<LogField> fields) {
  std::string payload;
  payload.reserve(message.size() + 32 * fields.size());
  append_printable(payload, message);
  for (const auto& [key, value] : fields) {
    payload.push_back(kFieldMark);
    payload.append(key);
    payload.push_back('=');
    append_printable(payload, value);
  }
  return payload;
}

}  // namespace dwell
