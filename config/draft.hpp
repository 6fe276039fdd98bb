// A rig file half read: what has been taken from it so far and where it stood, so that checks that look at several keys
// can say where. Internal to config. The steps run in the order below; each notes its mistakes and goes on.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/rig_file.hpp"
#include "config/section.hpp"

namespace dwell::config {

struct DeviceDraft {
  Section section;
  const dwell_driver_table* driver = nullptr;  // null: its keys are not checked
  bool clean = true;                           // the plugin's own keys of the device and its channels are without fault
};

struct ChannelDraft {
  Section section;
  bool measures_known = false;
  bool place_known = false;  // `at` and, if given, `relative_to` are places of the chain
};

struct Draft {
  Draft() = default;
  Draft(const Draft&) = delete;  // the sections point to `mistakes`
  Draft& operator=(const Draft&) = delete;

  RigFile file;
  MistakeList mistakes;
  std::optional<Section> rig, excitation, estimation, gpio;
  std::vector<DeviceDraft> devices;
  std::vector<ChannelDraft> channels;
  bool devices_named = true;  // every device has a name that can be read
  bool motion_known = true;
  bool boundary_known = false;
  bool masses_known = false;  // at least how many there are
  bool frequency_known = false;
};

// [rig], [excitation], [settling], [estimation].
void read_method(Section& root, Draft& draft);
// [[limit]]; needs [rig].
void read_limits(Section& root, Draft& draft);
// [server], [modbus_server], [recording], [gpio].
void read_service(Section& root, Draft& draft);
// The key "listen" of [server] or [modbus_server]. nullopt: not given, or wrong; the mistake is noted.
[[nodiscard]] std::optional<ListenAddress> read_listen(Section& section, const char* expected, Need need);
// The keys of [server].
void read_server(Section& section, Draft& draft);
// The keys of [modbus_server].
void read_modbus_server(Section& section, Draft& draft);
// [[device]], with the plugins' own keys.
void read_devices(Section& root, const SchemaSource& schemas, Draft& draft);
// [[channel]], likewise; needs what came before.
void read_channels(Section& root, const SchemaSource& schemas, Draft& draft);
// What the plugins say of their devices by these settings; rates are shifted where they may be (core/fit/folding.hpp).
void describe_devices(Draft& draft);
// What only the whole shows: names, chain, rates, and each plugin's own check.
void validate(Draft& draft);

// The plugin's own keys of a table, checked against its schema. driver null: as they are, those left out that no plugin
// could take; a name that can only be a misspelt common one is a mistake even then.
[[nodiscard]] std::vector<Entry> read_driver_keys(Section& section, const dwell_driver_table* driver, dwell_scope scope,
                                                  MistakeList& mistakes);
// What the plugin itself finds wrong with its keys of one device.
void run_driver_check(const DeviceDraft& device, std::size_t index, Draft& draft);

}  // namespace dwell::config
