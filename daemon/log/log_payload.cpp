#include "daemon/log/log_payload.hpp"

#include "core/base/printable.hpp"

namespace dwell {

std::string make_payload(std::string_view message, std::initializer_list<LogField> fields) {
  std::string payload;
  payload.reserve(message.size() + 32 * fields.size());
  payload += printable(message, ' ');
  for (const auto& [key, value] : fields) {
    payload.push_back(kFieldMark);
    payload.append(key);
    payload.push_back('=');
    payload += printable(value, ' ');
  }
  return payload;
}

}  // namespace dwell
