#include "daemon/ctl/pinned_key.hpp"

#include "daemon/record/bounded_lines.hpp"

namespace dwell::ctl {
namespace {

constexpr std::size_t kMostBytes = 1'000'000;  // of a file of keys: some ten thousand keys

record::Result<void> add_keys_of(record::BoundedLines& lines, const std::string& path,
                                 std::vector<record::PublicKey>& keys) {
  const std::size_t before = keys.size();
  int number = 0;
  for (std::string line; lines.next(line);) {
    ++number;
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (line.empty() || line.front() == '#') continue;
    if (lines.cut()) return tl::make_unexpected(path + ":" + std::to_string(number) + ": is too long for a key");
    auto key = record::PublicKey::parse(line);
    if (!key) return tl::make_unexpected(path + ":" + std::to_string(number) + ": " + key.error());
    keys.push_back(std::move(*key));
  }
  if (auto ended = lines.ended(); !ended) return ended;
  if (keys.size() == before) return tl::make_unexpected(path + ": holds no key; expected vkeys, one a line");
  return {};
}

}  // namespace

record::Result<std::vector<record::PublicKey>> pinned_keys(const std::vector<std::string>& asked) {
  std::vector<record::PublicKey> keys;
  for (const std::string& one : asked) {
    record::BoundedLines lines(one, kMostBytes, "keys");
    if (lines.is_open()) {
      if (auto added = add_keys_of(lines, one, keys); !added) return tl::make_unexpected(added.error());
      continue;
    }
    // A vkey contains "+"; few paths do.
    if (one.find('+') == std::string::npos)
      return tl::make_unexpected(one + ": there is no such file; expected a vkey or a file that holds one");
    auto key = record::PublicKey::parse(one);
    if (!key) return tl::make_unexpected(key.error());
    keys.push_back(std::move(*key));
  }
  return keys;
}

}  // namespace dwell::ctl
