#include "daemon/ctl/pinned_key.hpp"

#include <fstream>

namespace dwell::ctl {

record::Result<record::PublicKey> pinned_key(const std::string& asked) {
  std::ifstream file(asked);
  // A vkey contains "+"; few paths do.
  if (!file && asked.find('+') != std::string::npos) return record::PublicKey::parse(asked);
  if (!file) return tl::make_unexpected(asked + ": there is no such file; expected a vkey or a file that holds one");
  std::string line;
  std::getline(file, line);
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
  auto key = record::PublicKey::parse(line);
  if (!key) return tl::make_unexpected(asked + ": " + key.error());
  return key;
}

}  // namespace dwell::ctl
