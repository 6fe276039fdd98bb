// What the rig file says about one device, in the form that a plugin takes: typed keys and values.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "drivers/dwell_driver.h"

namespace dwell::config {

using Value = std::variant<bool, std::int64_t, double, std::string>;

// One key of the plugin's. With a schema the value has the type that the schema declares.
struct Entry {
  std::string key;
  Value value;
};

struct ChannelSettings {
  std::string name;
  std::uint16_t index = 0;  // into Rig::channels
  std::vector<Entry> entries;
};

struct DeviceSettings {
  std::string name;
  std::string driver;
  std::optional<double> rate_hz;  // of each channel: the key `rate` or the driver's default, shifted where it may be
  std::optional<double> asked_rate_hz;  // before it was shifted; none: it was not
  double most_rate_hz = 0.0;            // that its line can carry; 0: not known
  bool leads = false;                   // its stamps may run ahead of the clock, as the driver says
  bool recorded = false;                // it plays a recording, as the driver says
  std::int64_t age_ns = 0;              // of a reading that reaches the host at most, as the driver says; 0: not known
  std::vector<Entry> entries;
  std::vector<ChannelSettings> channels;
};

// A dwell_settings that points into a DeviceSettings and a directory, which must outlive it unchanged. It may be moved;
// what get() returned stays valid.
class DriverSettings {
 public:
  DriverSettings(const DeviceSettings& device, const std::string& directory);
  DriverSettings(DriverSettings&&) noexcept = default;
  DriverSettings& operator=(DriverSettings&&) noexcept = default;
  DriverSettings(const DriverSettings&) = delete;
  DriverSettings& operator=(const DriverSettings&) = delete;
  ~DriverSettings() = default;

  [[nodiscard]] const dwell_settings& get() const noexcept { return settings_; }

 private:
  std::vector<std::vector<dwell_entry>> entries_;  // the device's, then each channel's
  std::vector<dwell_channel> channels_;
  dwell_settings settings_{};
};

}  // namespace dwell::config
