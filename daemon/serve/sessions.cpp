#include "daemon/serve/sessions.hpp"

#include <openssl/crypto.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <stdexcept>
#include <utility>

namespace dwell {

std::string Sessions::begin(std::int64_t now_ns) {
  std::array<unsigned char, 32> random{};
  if (getentropy(random.data(), random.size()) != 0) throw std::runtime_error("no random bytes are to be had");
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string value;
  for (const unsigned char byte : random) (value += kDigits[byte >> 4U]) += kDigits[byte & 15U];
  if (open_.size() == kMost)
    end_at(std::min_element(open_.begin(), open_.end(),
                            [](const Session& a, const Session& b) { return a.used_ns < b.used_ns; }));
  open_.push_back({value, now_ns, now_ns});
  return value;
}

// In a time that does not depend on where the values differ.
std::vector<Sessions::Session>::iterator Sessions::find(std::string_view value) {
  return std::find_if(open_.begin(), open_.end(), [value](const Session& one) {
    return one.value.size() == value.size() && CRYPTO_memcmp(one.value.data(), value.data(), value.size()) == 0;
  });
}

void Sessions::end_at(std::vector<Session>::iterator session) {
  ended_.push_back(std::move(session->value));
  open_.erase(session);
}

void Sessions::end_overdue(std::int64_t now_ns) {
  for (auto one = open_.begin(); one != open_.end();) {
    const bool overdue = now_ns - one->used_ns > kUnused_ns || now_ns - one->begun_ns > kLongest_ns;
    if (!overdue) {
      ++one;
      continue;
    }
    const auto place = one - open_.begin();
    end_at(one);
    one = open_.begin() + place;
  }
}

std::vector<std::string> Sessions::take_ended(std::int64_t now_ns) {
  end_overdue(now_ns);
  return std::exchange(ended_, {});
}

bool Sessions::use(std::string_view value, std::int64_t now_ns) {
  end_overdue(now_ns);
  const auto found = find(value);
  if (found == open_.end()) return false;
  found->used_ns = now_ns;
  return true;
}

void Sessions::end(std::string_view value) {
  if (const auto found = find(value); found != open_.end()) end_at(found);
}

void Sessions::end_all() {
  while (!open_.empty()) end_at(open_.end() - 1);
}

std::string_view cookie_value(std::string_view field, std::string_view name) {
  while (!field.empty()) {
    const std::size_t end = std::min(field.find(';'), field.size());
    std::string_view one = field.substr(0, end);
    field.remove_prefix(std::min(end + 1, field.size()));
    while (!one.empty() && one.front() == ' ') one.remove_prefix(1);
    if (one.size() > name.size() && one.substr(0, name.size()) == name && one[name.size()] == '=')
      return one.substr(name.size() + 1);
  }
  return {};
}

}  // namespace dwell
