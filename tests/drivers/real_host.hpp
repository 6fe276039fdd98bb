// A driver under the service's own host: DeviceHost with its ring, drained by a thread as the service drains it.
// Between driver and host stands a FakeHost that hands everything on and remembers it, so that what the host says it
// got can be held against what the driver said.
#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "daemon/acquire/device_host.hpp"
#include "tests/drivers/fake_host.hpp"

namespace dwell::test {

inline config::Value value_of(const dwell_entry& entry) {
  switch (entry.type) {
    case DWELL_BOOLEAN:
      return entry.boolean != 0;
    case DWELL_INTEGER:
      return entry.integer;
    case DWELL_REAL:
      return entry.real;
    case DWELL_STRING:
      break;
  }
  return std::string(entry.string);
}

// The settings as the rig file's reader would have them.
inline config::DeviceSettings device_settings_of(const dwell_settings& given) {
  const auto entries_of = [](const dwell_entry* entries, std::size_t count) {
    std::vector<config::Entry> made;
    for (std::size_t i = 0; i < count; ++i) made.push_back({entries[i].key, value_of(entries[i])});
    return made;
  };
  config::DeviceSettings settings;
  settings.name = given.device;
  settings.entries = entries_of(given.entries, given.entry_count);
  for (std::size_t i = 0; i < given.channel_count; ++i) {
    const dwell_channel& channel = given.channels[i];
    settings.channels.push_back({channel.name, channel.index, entries_of(channel.entries, channel.entry_count)});
  }
  return settings;
}

class RealInstance : public Driven {
 public:
  // capacity: samples that the ring holds; 0: as in the service.
  RealInstance(const dwell_driver_table& table, const dwell_settings& settings, FakeHost& between,
               std::size_t capacity = 0)
      : inner_(table), table_(table), between_(between) {
    table_.create = &create;
    making_ = this;
    auto made = DeviceHost::make(device_settings_of(settings), settings.directory, table_, nullptr, capacity);
    making_ = nullptr;
    if (made)
      host_ = std::move(*made);
    else
      error_ = made.error();
  }
  ~RealInstance() override {
    stop();
    taker_ = {};
  }
  RealInstance(const RealInstance&) = delete;
  RealInstance& operator=(const RealInstance&) = delete;

  bool exists() const override { return host_ != nullptr; }
  const std::string& error() const override { return error_; }
  bool start() override {
    const auto done = host_->start();
    error_ = done ? "" : done.error();
    return done.has_value();
  }
  double stop() override {
    const std::int64_t before_ns = driver::monotonic_ns();
    if (host_ != nullptr) host_->stop();
    return static_cast<double>(driver::monotonic_ns() - before_ns) * 1e-9;
  }
  DeviceLink& link() { return host_->link(); }

  // Takes what is in the ring from now on.
  void take() {
    taker_ = std::jthread([this](const std::stop_token& end) {
      while (!end.stop_requested()) {
        drain();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    });
  }
  // Stops, and takes what is left. Then the following are all that the host got.
  void finish() {
    stop();
    taker_ = {};
    drain();
  }
  const std::vector<Record>& records() const { return records_; }
  // As told last; by position among the link's channels.
  FakeHost::State state(std::size_t position) const { return states_.at(position); }

 private:
  static void* create(const dwell_settings* settings, const dwell_host* host, char* error, std::size_t size) {
    making_->between_.set_behind(*host);
    return making_->inner_.create(settings, making_->between_.host(), error, size);
  }

  void drain() {
    StateEvent event;
    while (link().pop_event(event))
      for (std::size_t i = 0; i < states_.size(); ++i)
        if (event.channel < 0 || link().position(static_cast<std::size_t>(event.channel)) == static_cast<int>(i))
          states_[i] = {static_cast<dwell_fault>(event.fault), event.reason.data()};
    std::array<Record, 64> some{};
    while (const std::size_t taken = link().pop_samples(some.data(), some.size()))
      records_.insert(records_.end(), some.begin(), some.begin() + taken);
  }

  static inline thread_local RealInstance* making_ = nullptr;
  const dwell_driver_table& inner_;
  dwell_driver_table table_;  // with our create
  FakeHost& between_;
  std::unique_ptr<DeviceHost> host_;
  std::string error_;
  std::vector<Record> records_;
  std::array<FakeHost::State, 2> states_;
  std::jthread taker_;
};

}  // namespace dwell::test
