#include "daemon/acquire/device_host.hpp"

#include <algorithm>
#include <array>

#include "daemon/clock.hpp"

namespace dwell {
namespace {

std::vector<std::uint16_t> indices(const config::DeviceSettings& settings) {
  std::vector<std::uint16_t> channels;
  channels.reserve(settings.channels.size());
  for (const config::ChannelSettings& channel : settings.channels) channels.push_back(channel.index);
  return channels;
}

using ErrorText = std::array<char, 512>;

std::string text_of(ErrorText& error, const char* otherwise) {
  error.back() = '\0';
  return error.front() != '\0' ? error.data() : otherwise;
}

}  // namespace

std::size_t ring_capacity(const config::DeviceSettings& settings) noexcept {
  constexpr double kSeconds = 2.0;
  const double samples = settings.rate_hz.value_or(0.0) * static_cast<double>(settings.channels.size()) * kSeconds;
  return static_cast<std::size_t>(std::clamp(samples, 4096.0, 262144.0));
}

DeviceHost::DeviceHost(const config::DeviceSettings& settings, const dwell_driver_table& table, DeviceLink::LogLine log,
                       std::size_t capacity)
    : link_(settings.name, indices(settings), capacity, std::move(log)), table_(table) {}

tl::expected<std::unique_ptr<DeviceHost>, std::string> DeviceHost::make(const config::DeviceSettings& settings,
                                                                        const std::string& directory,
                                                                        const dwell_driver_table& table,
                                                                        DeviceLink::LogLine log, std::size_t capacity) {
  if (capacity == 0) capacity = ring_capacity(settings);
  std::unique_ptr<DeviceHost> made(new DeviceHost(settings, table, std::move(log), capacity));
  const config::DriverSettings driver_settings(settings, directory);
  const dwell_host host = made->link_.host();
  ErrorText error{};
  made->instance_ = table.create(&driver_settings.get(), &host, error.data(), error.size());
  if (made->instance_ == nullptr)
    return tl::unexpected("device " + settings.name + ": " + text_of(error, "the driver refused"));
  return made;
}

DeviceHost::~DeviceHost() {
  stop();
  if (instance_ != nullptr) table_.destroy(instance_);
}

tl::expected<void, std::string> DeviceHost::start() {
  ErrorText error{};
  link_.turn(raw_now_ns());
  if (table_.start(instance_, error.data(), error.size()) != 0)
    return tl::unexpected("device " + link_.name() + ": " + text_of(error, "the driver did not start"));
  started_ = true;
  return {};
}

void DeviceHost::stop() noexcept {
  if (!started_) return;
  started_ = false;
  table_.stop(instance_);
}

}  // namespace dwell
