#include "daemon/record/file_name.hpp"

#include <charconv>
#include <filesystem>

#include "daemon/record/disk_reserve.hpp"

namespace dwell::record {
namespace {

constexpr std::size_t kLongest = 64;

bool is_tame(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '_';
}

}  // namespace

std::string ledger_in(const std::string& directory) {
  return (std::filesystem::path(directory) / "ledger.dwell-ledger").string();
}

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

std::string first_name_of_run(std::int64_t run) { return "next-" + std::to_string(run) + ".new"; }

std::string kept_by_service(std::string_view name) {
  if (name == "key" || name == "key.next") return "the private key of the service";
  if (name == "key.pub") return "the public key of the service";
  if (name == kReserveName) return "the room that the service reserves on the disk";
  for (const std::string_view part : {"-wal", "-shm", "-journal"})
    if (name.ends_with(part)) name.remove_suffix(part.size());
  return name.starts_with("next-") && name.ends_with(".new") ? "a run that the service makes in advance" : "";
}

std::int64_t run_of_file_name(std::string_view name) {
  if (name.size() < kRunSuffix.size() || name.substr(name.size() - kRunSuffix.size()) != kRunSuffix) return 0;
  const std::size_t before_utc = name.rfind('-');
  if (before_utc == std::string_view::npos || before_utc == 0) return 0;
  const std::size_t before_run = name.rfind('-', before_utc - 1);
  if (before_run == std::string_view::npos) return 0;
  std::int64_t run = 0;
  const char* const end = name.data() + before_utc;
  const auto [stopped, error] = std::from_chars(name.data() + before_run + 1, end, run);
  return error == std::errc{} && stopped == end && run > 0 ? run : 0;
}

}  // namespace dwell::record
