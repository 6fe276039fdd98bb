#include "daemon/record/file_name.hpp"

namespace dwell::record {
namespace {

constexpr std::size_t kLongest = 64;

bool is_tame(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_';
}

}  // namespace

std::string tame(std::string_view text) {
  std::string name;
  for (const char c : text) {
    if (name.size() == kLongest) break;
    if (is_tame(c) && !(c == '.' && name.empty())) {
      name += c;
    } else if (!name.empty() && name.back() != '-') {
      name += '-';
    }
  }
  while (!name.empty() && name.back() == '-') name.pop_back();
  return name.empty() ? "rig" : name;
}

std::string run_file_name(std::string_view rig, std::int64_t run, std::string_view utc) {
  return tame(rig) + '-' + std::to_string(run) + '-' + std::string(utc) + std::string(kRunSuffix);
}

}  // namespace dwell::record
