#include <filesystem>

#include "config/draft.hpp"

namespace dwell::config {
namespace {

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

void read_retention(const toml::table& table, RecordingSettings& recording, MistakeList& mistakes) {
  Section retain(table, "\"retain\"", mistakes);
  double days = 0.0, gigabytes = 0.0;
  constexpr double kMost = 1e6;
  if (retain.real("days", days, {"a number above 0, at most 1e6 (days)", 0.0, kMost, true}))
    recording.retain_days = days;
  if (retain.real("gigabytes", gigabytes, {"a number above 0, at most 1e6 (10^9 bytes)", 0.0, kMost, true}))
    recording.retain_gigabytes = gigabytes;
  retain.refuse_rest();
}

// The program and its arguments, as they are: no shell looks at them.
void read_command(Section& anchor, std::vector<std::string>& command) {
  constexpr const char* kCommand =
      "a program by its whole path and its arguments, for instance [\"/usr/local/bin/send-head\", \"lab\"]";
  const toml::array* given = anchor.array("command", kCommand);
  if (given == nullptr) return;
  for (const toml::node& node : *given) {
    const auto* word = node.as_string();
    if (word == nullptr || !is_one_line(word->get()))
      return anchor.wrong("command", "\"command\" holds " + shown(node) + ": expected " + kCommand);
    command.push_back(word->get());
  }
  if (command.empty() || command.front().front() != '/')
    anchor.wrong("command", "\"command\" names no program by its whole path: expected " + std::string(kCommand));
}

void read_anchor(const toml::table& table, Draft& draft) {
  Section section(table, "\"anchor\"", draft.mistakes);
  AnchorSettings& anchor = draft.file.recording.anchor.emplace();
  section.real("minutes", anchor.minutes, {"a number from 1 to 10080 (minutes)", 1.0, 10080.0});
  std::string file;
  if (section.text("file", file, "a file that gets a line for each anchor, a path"))
    anchor.file = (std::filesystem::path(draft.file.directory) / file).string();
  read_command(section, anchor.command);
  const bool has_file = section.peek("file") != nullptr, has_command = section.peek("command") != nullptr;
  if (has_file == has_command)
    section.wrong(has_file ? "command" : "",
                  has_file ? "\"anchor\" has a \"file\" and a \"command\": expected one of them"
                           : "\"anchor\" has neither \"file\" nor \"command\": expected one of them");
  section.refuse_rest();
}

void read_recording(Section& section, Draft& draft) {
  RecordingSettings& recording = draft.file.recording;
  recording.on = true;
  std::string directory;
  if (section.text("directory", directory, "the directory of the recordings, a path"))
    recording.directory = (std::filesystem::path(draft.file.directory) / directory).string();
  section.real("every", recording.every_s, {"a number from 0.1 to 3600 (s)", 0.1, 3600.0});
  if (const toml::table* table = section.table("retain", "a table { days, gigabytes }"))
    read_retention(*table, recording, draft.mistakes);
  if (const toml::table* table = section.table("anchor", "a table { minutes, file } or { minutes, command }"))
    read_anchor(*table, draft);
  section.refuse_rest();
}

}  // namespace

void read_service(Section& root, Draft& draft) {
  if (const toml::table* table = root.table("server", "a table [server]")) {
    Section section(*table, "[server]", draft.mistakes);
    read_server(section, draft);
  }
  if (const toml::table* table = root.table("modbus_server", "a table [modbus_server]")) {
    Section section(*table, "[modbus_server]", draft.mistakes);
    read_modbus_server(section, draft);
  }
  if (const toml::table* table = root.table("recording", "a table [recording]")) {
    Section section(*table, "[recording]", draft.mistakes);
    read_recording(section, draft);
  }
  if (const toml::table* table = root.table("gpio", "a table [gpio]")) {
    draft.gpio.emplace(*table, "[gpio]", draft.mistakes);
    read_gpio(*draft.gpio, draft);
  }
}

}  // namespace dwell::config
