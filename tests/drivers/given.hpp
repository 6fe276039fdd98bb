// A device as config would hand it to a plugin, written down in a test: Given("amplifier").set("rate", 100)
// .channel("y0").set("register", 0). set() goes to the channel added last, before that to the device.
#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <type_traits>
#include <vector>

#include "drivers/dwell_driver.h"

namespace dwell::test {

class Given {
 public:
  explicit Given(std::string device, std::string directory = "") {
    device_ = keep(std::move(device));
    directory_ = keep(std::move(directory));
    tables_.emplace_back();
  }

  template <class T>
  Given& set(const std::string& key, const T& value) {
    dwell_entry entry{};
    entry.key = keep(key);
    if constexpr (std::is_same_v<T, bool>) {
      entry.type = DWELL_BOOLEAN;
      entry.boolean = value ? 1 : 0;
    } else if constexpr (std::is_integral_v<T>) {
      entry.type = DWELL_INTEGER;
      entry.integer = value;
      entry.real = static_cast<double>(value);
    } else if constexpr (std::is_floating_point_v<T>) {
      entry.type = DWELL_REAL;
      entry.real = value;
    } else {
      entry.type = DWELL_STRING;
      entry.string = keep(value);
    }
    tables_.back().push_back(entry);
    return *this;
  }

  // Channels are numbered from 10, so that an index mistaken for a position shows.
  Given& channel(std::string name) {
    names_.push_back(keep(std::move(name)));
    tables_.emplace_back();
    return *this;
  }
  static constexpr std::uint16_t kFirstIndex = 10;

  // Valid as long as this object, until it is changed.
  const dwell_settings* settings() {
    channels_.clear();
    for (std::size_t i = 0; i < names_.size(); ++i)
      channels_.push_back(
          {names_[i], static_cast<std::uint16_t>(kFirstIndex + i), tables_[i + 1].data(), tables_[i + 1].size()});
    settings_ = {sizeof settings_,  device_,          directory_,      tables_[0].data(),
                 tables_[0].size(), channels_.data(), channels_.size()};
    return &settings_;
  }

 private:
  const char* keep(std::string text) { return texts_.emplace_back(std::move(text)).c_str(); }

  std::deque<std::string> texts_;
  const char* device_;
  const char* directory_;
  std::vector<const char*> names_;
  std::deque<std::vector<dwell_entry>> tables_;  // the device's, then one per channel
  std::vector<dwell_channel> channels_;
  dwell_settings settings_{};
};

}  // namespace dwell::test
