#include <arpa/inet.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

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
  return !host.empty() && host.size() <= 253 && letters && !digits && host.front() != '-' && host.front() != '.';
}

// Splits and checks an address to listen on; false: it is none.
bool split_address(const std::string& address, ServerSettings& out) {
  const std::size_t colon = address.rfind(':');
  if (colon == std::string::npos) return false;
  std::string host = address.substr(0, colon);
  unsigned char binary[16];
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
    if (inet_pton(AF_INET6, host.c_str(), binary) != 1) return false;
  } else if (inet_pton(AF_INET, host.c_str(), binary) != 1 && host != "localhost") {
    return false;
  }
  const char* const first = address.data() + colon + 1;
  const char* const last = address.data() + address.size();
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(first, last, port);
  if (first == last || error != std::errc() || end != last) return false;
  out.listen = address;
  out.host = host;
  out.port = port;
  return true;
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
      names.push_back(name->get());
    }
  }
}

std::optional<GpioLine> read_line(Section& gpio, const char* name, bool input, Draft& draft) {
  const toml::table* table = gpio.table(name, "a table { chip, line, active_low }");
  if (table == nullptr) return std::nullopt;
  GpioLine line;
  Section section(*table, std::string("\"") + name + "\"", draft.mistakes);
  section.text("chip", line.chip, "the chip's device file, for instance \"/dev/gpiochip0\"", Need::required);
  std::int64_t number = 0;
  section.integer("line", number, 0, 65535, "the line's number on its chip, 0 to 65535", Need::required);
  line.line = static_cast<unsigned>(number);
  section.boolean("active_low", line.active_low);
  if (input) {
    using Bias = GpioLine::Bias;
    section.choice<Bias>("bias", line.bias,
                         {{"as-is", Bias::as_is},
                          {"disabled", Bias::disabled},
                          {"pull-up", Bias::pull_up},
                          {"pull-down", Bias::pull_down}});
    section.real("debounce", line.debounce_s, {"a number from 0 to 1 (s)", 0.0, 1.0});
    const double period_s = draft.frequency_known ? 1.0 / draft.file.rig.excitation.frequency_hz : 0.0;
    if (name == std::string_view("sync") && period_s > 0.0 && line.debounce_s >= period_s / 2.0) {
      section.wrong("debounce", "\"debounce\" is " + number_text(line.debounce_s) +
                                    " and would swallow pulses: expected less than half a period, " +
                                    number_text(period_s / 2.0) + " s");
    }
  }
  section.refuse_rest();
  return line;
}

void read_gpio(Section& section, Draft& draft) {
  GpioSettings& gpio = draft.file.gpio;
  struct Named {
    const char* name;
    bool input;
    std::optional<GpioLine>* target;
  };
  const Named lines[] = {{"interlock", true, &gpio.interlock},
                         {"sync", true, &gpio.sync},
                         {"ready", false, &gpio.ready},
                         {"fault", false, &gpio.fault}};
  for (const Named& line : lines) *line.target = read_line(section, line.name, line.input, draft);
  for (std::size_t i = 0; i < std::size(lines); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto &a = *lines[i].target, &b = *lines[j].target;
      if (a && b && !a->chip.empty() && a->chip == b->chip && a->line == b->line) {
        section.wrong(lines[i].name, std::string("\"") + lines[i].name + "\" is the same line as \"" + lines[j].name +
                                         "\": expected a line of its own");
      }
    }
  }
  section.refuse_rest();
}

}  // namespace

void read_service(Section& root, Draft& draft) {
  if (const toml::table* table = root.table("server", "a table [server]")) {
    Section section(*table, "[server]", draft.mistakes);
    std::string listen;
    if (section.text("listen", listen, kListen) && !split_address(listen, draft.file.server)) {
      section.wrong("listen", "\"listen\" is " + in_quotes(listen) + ": expected " + kListen);
    }
    read_names(section, draft.file.server.names);
    section.refuse_rest();
  }
  if (const toml::table* table = root.table("recording", "a table [recording]")) {
    Section section(*table, "[recording]", draft.mistakes);
    std::string directory;
    if (section.text("directory", directory, "the directory of the recordings, a path")) {
      draft.file.recording.directory = (std::filesystem::path(draft.file.directory) / directory).string();
    }
    section.refuse_rest();
  }
  if (const toml::table* table = root.table("gpio", "a table [gpio]")) {
    draft.gpio.emplace(*table, "[gpio]", draft.mistakes);
    read_gpio(*draft.gpio, draft);
  }
}

}  // namespace dwell::config
