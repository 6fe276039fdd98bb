#include <algorithm>

#include "config/draft.hpp"
#include "config/driver_table.hpp"

namespace dwell::config {
namespace {

constexpr const char* kDelay = "a number from -10 to 10 (s)";
constexpr const char* kRate = "a number from 0.001 to 1e6 (Hz)";
constexpr const char* kDelayU = "a number from 0 to 10 (s)";

const dwell_driver_table* find_driver(Section& section, const std::string& name, const SchemaSource& schemas) {
  if (!is_driver_name(name)) {
    section.wrong("driver", "\"driver\" is " + in_quotes(name) +
                                ": expected the name of a plugin, of the letters a-z, digits, - and _");
    return nullptr;
  }
  if (!schemas) return nullptr;
  const tl::expected<const dwell_driver_table*, std::string> found = schemas(name);
  if (found && *found != nullptr) return *found;
  section.wrong("driver", "driver " + in_quotes(name) + " is not available: " +
                              (found ? "expected the name of an installed plugin" : one_line(found.error())));
  return nullptr;
}

bool has_device_key(const dwell_driver_table& driver, std::string_view name) {
  const std::vector<dwell_key> keys = keys_of(driver);
  return std::any_of(keys.begin(), keys.end(),
                     [name](const dwell_key& key) { return key.scope == DWELL_DEVICE && key.name == name; });
}

void read_device(const toml::table& table, std::size_t number, const SchemaSource& schemas, Draft& draft) {
  DeviceDraft device{Section(table, "[[device]]", draft.mistakes)};
  Section& section = device.section;
  DeviceSettings settings;
  if (!section.text("name", settings.name, "the device's name, printable text", Need::required)) {
    settings.name = "device " + std::to_string(number);
    draft.devices_named = false;
  }
  if (section.text("driver", settings.driver, "the name of a plugin, for instance \"modbus\"", Need::required)) {
    device.driver = find_driver(section, settings.driver, schemas);
  }
  Device common;
  common.name = settings.name;
  section.choice("clock", common.clock, {{"host", Clock::host}, {"device", Clock::device}});
  const bool drivers_own = device.driver == nullptr || has_device_key(*device.driver, "rate");
  if (!drivers_own && section.real("rate", common.rate_hz, {kRate, 1e-3, 1e6})) settings.rate_hz = common.rate_hz;
  section.real("delay", common.delay_s, {kDelay, -10.0, 10.0});
  common.delay_u_stated = section.real("delay_u", common.delay_u_s, {kDelayU, 0.0, 10.0});
  const std::size_t before = draft.mistakes.count();
  settings.entries = read_driver_keys(section, device.driver, DWELL_DEVICE, draft.mistakes);
  device.clean = draft.mistakes.count() == before;
  const bool rate_fits = std::any_of(settings.entries.begin(), settings.entries.end(),
                                     [](const Entry& entry) { return entry.key == "rate"; });
  if (const toml::node* rate = section.peek("rate"); rate_fits && rate->is_number()) {
    settings.rate_hz = rate->value<double>();
  }
  common.rate_hz = settings.rate_hz.value_or(0.0);

  draft.file.rig.devices.push_back(std::move(common));
  draft.file.devices.push_back(std::move(settings));
  draft.devices.push_back(std::move(device));
}

}  // namespace

void read_devices(Section& root, const SchemaSource& schemas, Draft& draft) {
  constexpr const char* expected = "at least one table [[device]]";
  const toml::array* devices = root.array("device", expected, schemas ? Need::required : Need::optional);
  if (devices == nullptr) return;
  if (devices->size() > kMaxDevices) {
    root.wrong("device", std::to_string(devices->size()) + " devices: expected at most " + std::to_string(kMaxDevices));
    return;
  }
  if (devices->empty() && schemas) root.wrong("device", std::string("\"device\" is empty: expected ") + expected);
  for (const toml::node& node : *devices) {
    if (const toml::table* table = node.as_table()) {
      read_device(*table, draft.devices.size() + 1, schemas, draft);
    } else {
      draft.mistakes.add(position(node),
                         std::string("a device is ") + type_name(node) + ": expected a table [[device]]");
    }
  }
}

}  // namespace dwell::config
