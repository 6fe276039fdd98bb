#include "daemon/serve/host_check.hpp"

#include <arpa/inet.h>

#include <algorithm>

namespace dwell {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_address(int family, std::string_view text) {
  unsigned char binary[16];
  return inet_pton(family, std::string(text).c_str(), binary) == 1;
}

bool is_port(std::string_view text) {
  return text.empty() || (text.front() == ':' && text.find_first_not_of("0123456789", 1) == std::string_view::npos);
}

}  // namespace

bool same_name(std::string_view a, std::string_view b) noexcept {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return lower(x) == lower(y); });
}

bool is_our_host(std::string_view host, const std::vector<std::string>& names) {
  if (!host.empty() && host.front() == '[') {
    const auto end = host.find(']');
    return end != std::string_view::npos && is_port(host.substr(end + 1)) &&
           is_address(AF_INET6, host.substr(1, end - 1));
  }
  const auto colon = std::min(host.find(':'), host.size());
  if (!is_port(host.substr(colon))) return false;
  std::string_view name = host.substr(0, colon);
  if (is_address(AF_INET, name)) return true;
  if (!name.empty() && name.back() == '.') name.remove_suffix(1);
  const auto is_name = [name](std::string_view known) { return same_name(name, known); };
  return !name.empty() && (is_name("localhost") || std::any_of(names.begin(), names.end(), is_name));
}

}  // namespace dwell
