#include <algorithm>
#include <cmath>

#include "config/draft.hpp"
#include "config/driver_table.hpp"

namespace dwell::config {
namespace {

std::string expected_of(const dwell_key& key) {
  std::string out;
  const bool bounded = key.minimum <= key.maximum;
  const std::string unit = key.unit != nullptr && *key.unit != '\0' ? std::string(" (") + key.unit + ")" : "";
  switch (key.type) {
    case DWELL_BOOLEAN:
      return "true or false";
    case DWELL_INTEGER:
      out = "an integer";
      break;
    case DWELL_REAL:
      out = "a number";
      break;
    case DWELL_STRING:
      if (key.choices == nullptr || *key.choices == '\0') return "text";
      out = std::string("one of ") + key.choices;
      std::replace(out.begin(), out.end(), '|', ' ');
      return out;
  }
  if (bounded && std::isfinite(key.minimum)) out += ", at least " + number_text(key.minimum);
  if (bounded && std::isfinite(key.maximum)) out += ", at most " + number_text(key.maximum);
  return out + unit;
}

bool is_choice(std::string_view choices, std::string_view text) {
  for (std::size_t begin = 0; begin <= choices.size();) {
    const std::size_t end = std::min(choices.find('|', begin), choices.size());
    if (choices.substr(begin, end - begin) == text) return true;
    begin = end + 1;
  }
  return false;
}

// The value in the type that the schema declares; none: it is of another type or out of bounds.
std::optional<Value> fit_value(const dwell_key& key, const toml::node& node) {
  const RealRule bounds = key.minimum <= key.maximum ? RealRule{"", key.minimum, key.maximum} : RealRule{""};
  switch (key.type) {
    case DWELL_BOOLEAN:
      if (const auto* boolean = node.as_boolean()) return Value(boolean->get());
      break;
    case DWELL_INTEGER:
      if (const auto* integer = node.as_integer(); integer && bounds.admits(static_cast<double>(integer->get()))) {
        return Value(integer->get());
      }
      break;
    case DWELL_REAL:
      if (node.is_number() && bounds.admits(node.value<double>().value_or(0.0))) return Value(*node.value<double>());
      break;
    case DWELL_STRING:
      if (const auto* text = node.as_string()) {
        const bool free = key.choices == nullptr || *key.choices == '\0';
        // A plugin sees text up to its first NUL: what it would not see whole it must not get.
        const bool whole = text->get().find('\0') == std::string::npos;
        if (whole && (free || is_choice(key.choices, text->get()))) return Value(text->get());
      }
      break;
  }
  return std::nullopt;
}

// A value that some plugin could take; none: an array, a table, a date.
std::optional<Value> any_value(const toml::node& node) {
  if (const auto* boolean = node.as_boolean()) return Value(boolean->get());
  if (const auto* integer = node.as_integer()) return Value(integer->get());
  if (const auto* real = node.as_floating_point()) return Value(real->get());
  if (const auto* text = node.as_string()) return Value(text->get());
  return std::nullopt;
}

std::vector<Entry> unchecked_keys(Section& section) {
  std::vector<std::string> not_given;
  for (const std::string& name : section.asked()) {
    if (section.peek(name) == nullptr && name.size() >= 4) not_given.push_back(name);
  }
  std::vector<Entry> out;
  for (const auto& [key, node] : section.rest()) {
    // Without a schema "scal" would pass for a plugin's key, and the reading would be wrong by its scale.
    if (!nearest_name(key, not_given, 1).empty()) {
      section.refuse(key);
    } else if (std::optional<Value> value = any_value(*node)) {
      out.push_back({key, std::move(*value)});
    }
  }
  return out;
}

struct CheckContext {
  const DeviceDraft* device;
  const DeviceSettings* settings;
  Draft* draft;
};

void take_report(void* context, int32_t channel, const char* key, const char* message) {
  auto& [device, settings, draft] = *static_cast<CheckContext*>(context);
  const Section* section = &device->section;
  if (channel >= 0 && static_cast<std::size_t>(channel) < settings->channels.size()) {
    section = &draft->channels[settings->channels[static_cast<std::size_t>(channel)].index].section;
  }
  const Position at = key == nullptr ? section->where() : section->where(key);
  draft->mistakes.add(at, one_line(message == nullptr ? "the driver refuses this without a reason" : message));
}

}  // namespace

std::vector<Entry> read_driver_keys(Section& section, const dwell_driver_table* driver, dwell_scope scope,
                                    MistakeList& mistakes) {
  if (driver == nullptr) return unchecked_keys(section);
  std::vector<Entry> out;
  for (const dwell_key& key : keys_of(*driver)) {
    if (key.scope != scope) continue;
    const toml::node* node = section.value(key.name);
    if (node == nullptr) {
      if (key.required != 0) section.missing(key.name, expected_of(key));
    } else if (std::optional<Value> value = fit_value(key, *node)) {
      out.push_back({key.name, std::move(*value)});
    } else {
      mistakes.add(section.where(key.name),
                   in_quotes(key.name) + " is " + shown(*node) + ": expected " + expected_of(key));
    }
  }
  section.refuse_rest();
  return out;
}

void run_driver_check(const DeviceDraft& device, std::size_t index, Draft& draft) {
  if (device.driver == nullptr || device.driver->check == nullptr || !device.clean) return;
  const DeviceSettings& settings = draft.file.devices[index];
  // A channel whose device cannot be told may be the one that this device seems to lack.
  const std::vector<Channel>& channels = draft.file.rig.channels;
  const auto homeless = [](const Channel& channel) { return channel.device < 0; };
  if (settings.channels.empty() && std::any_of(channels.begin(), channels.end(), homeless)) return;
  const DriverSettings as_c(settings, draft.file.directory);
  CheckContext context{&device, &settings, &draft};
  device.driver->check(&as_c.get(), take_report, &context);
}

}  // namespace dwell::config
