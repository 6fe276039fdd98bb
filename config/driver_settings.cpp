#include "config/driver_settings.hpp"

namespace dwell::config {
namespace {

dwell_entry c_entry(const Entry& entry) {
  dwell_entry out{};
  out.key = entry.key.c_str();
  if (const bool* boolean = std::get_if<bool>(&entry.value)) {
    out.type = DWELL_BOOLEAN;
    out.boolean = *boolean ? 1 : 0;
  } else if (const std::int64_t* integer = std::get_if<std::int64_t>(&entry.value)) {
    out.type = DWELL_INTEGER;
    out.integer = *integer;
    out.real = static_cast<double>(*integer);
  } else if (const double* real = std::get_if<double>(&entry.value)) {
    out.type = DWELL_REAL;
    out.real = *real;
  } else {
    out.type = DWELL_STRING;
    out.string = std::get<std::string>(entry.value).c_str();
  }
  return out;
}

std::vector<dwell_entry> c_entries(const std::vector<Entry>& entries) {
  std::vector<dwell_entry> out;
  out.reserve(entries.size());
  for (const Entry& entry : entries) out.push_back(c_entry(entry));
  return out;
}

}  // namespace

DriverSettings::DriverSettings(const DeviceSettings& device, const std::string& directory) {
  entries_.reserve(device.channels.size() + 1);
  entries_.push_back(c_entries(device.entries));
  for (const ChannelSettings& channel : device.channels) {
    entries_.push_back(c_entries(channel.entries));
    channels_.push_back({channel.name.c_str(), channel.index, entries_.back().data(), entries_.back().size()});
  }
  settings_.size = sizeof settings_;
  settings_.device = device.name.c_str();
  settings_.directory = directory.c_str();
  settings_.entries = entries_.front().data();
  settings_.entry_count = entries_.front().size();
  settings_.channels = channels_.data();
  settings_.channel_count = channels_.size();
}

}  // namespace dwell::config
