// One device: its plugin instance, created, started, stopped and destroyed in that order, and the link it delivers
// into.
#pragma once

#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "config/rig_file.hpp"
#include "daemon/acquire/device_link.hpp"
#include "drivers/dwell_driver.h"

namespace dwell {

class DeviceHost {
 public:
  // Makes the instance; the device is not touched. directory: of the rig file. `table` stays valid for ever. capacity:
  // samples that the ring holds; 0: as ring_capacity says.
  static tl::expected<std::unique_ptr<DeviceHost>, std::string> make(const config::DeviceSettings& settings,
                                                                     const std::string& directory,
                                                                     const dwell_driver_table& table,
                                                                     DeviceLink::LogLine log, std::size_t capacity = 0);
  ~DeviceHost();
  DeviceHost(const DeviceHost&) = delete;
  DeviceHost& operator=(const DeviceHost&) = delete;

  tl::expected<void, std::string> start();
  // Returns when the driver has ended delivering, within 0.5 s. Harmless when not started or stopped already.
  void stop() noexcept;

  [[nodiscard]] DeviceLink& link() noexcept { return link_; }
  [[nodiscard]] const DeviceLink& link() const noexcept { return link_; }

 private:
  DeviceHost(const config::DeviceSettings& settings, const dwell_driver_table& table, DeviceLink::LogLine log,
             std::size_t capacity);

  DeviceLink link_;
  const dwell_driver_table& table_;
  void* instance_ = nullptr;
  bool started_ = false;
};

// Samples a device's ring holds: two seconds' worth where its rate is known, within [4096, 262144].
[[nodiscard]] std::size_t ring_capacity(const config::DeviceSettings& settings) noexcept;

}  // namespace dwell
