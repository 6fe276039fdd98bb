#include <algorithm>
#include <filesystem>
#include <utility>

#include "config/draft.hpp"

namespace dwell::config {
namespace {

constexpr const char* kListen =
    "\"ADDRESS:PORT\" with a numeric address or localhost, for instance \"127.0.0.1:8380\" or \"[::1]:8380\"";

bool is_host_name(const std::string& host) {
  const bool letters = std::all_of(host.begin(), host.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '.';
  });
  // Digits and dots alone mean an address, and then a broken one.
  const bool digits = host.find_first_not_of("0123456789.") == std::string::npos;
  const bool labels = host.find("..") == std::string::npos;
  return !host.empty() && host.size() <= 253 && letters && !digits && labels && host.front() != '-' &&
         host.front() != '.';
}

void read_names(Section& server, std::vector<std::string>& names) {
  constexpr const char* kNames = "host names without a port, for instance [\"bench.local\"]";
  const toml::array* given = server.array("names", kNames);
  if (given == nullptr) return;
  for (const toml::node& node : *given) {
    const auto* name = node.as_string();
    if (name == nullptr || !is_host_name(name->get())) {
      server.wrong("names", "\"names\" holds " + shown(node) + ": expected " + kNames);
    } else {
      // "bench.local." is the same host (RFC 1034, 3.1); requests are compared without the dot.
      const std::string& host = name->get();
      names.push_back(host.substr(0, host.size() - (host.back() == '.' ? 1 : 0)));
    }
  }
}

}  // namespace

std::optional<ListenAddress> read_listen(Section& section, const char* expected, Need need) {
  std::string listen;
  if (!section.text("listen", listen, expected, need)) return std::nullopt;
  auto address = split_address(listen);
  if (address && !is_multicast_or_broadcast(address->host)) return address;
  section.wrong("listen", "\"listen\" is " + in_quotes(listen) +
                              (address ? ", a multicast or broadcast address: expected an address of this computer"
                                       : std::string(": expected ") + expected));
  return std::nullopt;
}

void read_server(Section& section, Draft& draft) {
  ServerSettings& server = draft.file.server;
  std::string token_file;
  if (auto address = read_listen(section, kListen, Need::optional)) server.listen = std::move(*address);
  read_names(section, server.names);
  if (section.text("token_file", token_file, "the file that holds the token, a path"))
    server.token_file = (std::filesystem::path(draft.file.directory) / token_file).string();
  section.boolean("behind_proxy", server.behind_proxy);
  server.listen_at = section.where("listen");
  server.token_file_at = section.where("token_file");
  section.refuse_rest();
}

}  // namespace dwell::config
