#include "daemon/serve/sessions.hpp"

#include <openssl/crypto.h>
#include <unistd.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "daemon/record/digest.hpp"
#include "daemon/serve/next_part.hpp"

namespace dwell {

std::string Sessions::begin(std::int64_t now_ns) {
  record::Digest random{};
  if (getentropy(random.data(), random.size()) != 0) throw std::runtime_error("no random bytes are to be had");
  const std::string value = record::hex(random);
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
    std::string_view one = next_part(field, ';');
    while (!one.empty() && one.front() == ' ') one.remove_prefix(1);
    if (one.size() > name.size() && one.substr(0, name.size()) == name && one[name.size()] == '=')
      return one.substr(name.size() + 1);
  }
  return {};
}

}  // namespace dwell
