// A host that remembers what a driver did, alone or before another host. Its push allocates nothing, so that a test can
// count what the driver allocates (and the other host).
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/dwell_driver.hpp"

namespace dwell::test {

// Allocations by operator new of the calling thread so far; 0 in programs without a counting operator new.
std::size_t allocations_of_this_thread() noexcept;

// Polls until `condition` holds; false after a time that only a hang takes.
inline bool eventually(const std::function<bool()>& condition) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

class FakeHost {
 public:
  struct State {
    dwell_fault fault = DWELL_FAULT_SILENT;
    std::string reason;
  };

  FakeHost() {
    samples_.reserve(kCapacity);
    scans_.reserve(kCapacity);
    host_ = {sizeof host_, this, &push, &state, &count, &log, &turn, &room};
  }
  const dwell_host* host() const { return &host_; }
  // From now on everything is handed on to another host, which decides what there is room for.
  void set_behind(const dwell_host& host) { behind_ = host; }

  std::vector<dwell_sample> samples() const {
    const std::lock_guard lock(mutex_);
    return samples_;
  }
  std::vector<dwell_sample> samples(std::uint16_t channel) const {
    std::vector<dwell_sample> mine;
    for (const dwell_sample& sample : samples())
      if (sample.channel == channel) mine.push_back(sample);
    return mine;
  }
  std::size_t sample_count() const {
    const std::lock_guard lock(mutex_);
    return samples_.size();
  }
  // Sizes of the accepted scans, in order.
  std::vector<std::size_t> scans() const {
    const std::lock_guard lock(mutex_);
    return scans_;
  }
  std::size_t refused() const { return refused_; }
  // The state of a channel as told last, for itself or for all.
  State state_of(std::uint16_t channel) const {
    const std::lock_guard lock(mutex_);
    const auto place = states_.find(channel);
    return place == states_.end() ? State{} : place->second;
  }
  std::size_t states_told() const { return states_told_; }
  int counted(dwell_fault fault) const { return counts_.at(static_cast<std::size_t>(fault)); }
  std::vector<std::string> logged() const {
    const std::lock_guard lock(mutex_);
    return logged_;
  }
  std::size_t turns() const { return turns_; }
  // The longest time between two turns so far, the time since the last one included.
  double longest_pause_s() const {
    const std::int64_t since_ns = driver::monotonic_ns() - last_turn_ns_;
    return static_cast<double>(std::max<std::int64_t>(longest_pause_ns_, since_ns)) * 1e-9;
  }
  // Scans before which the driver's thread allocated although it had nothing to tell, but for the first 20.
  std::size_t allocating_scans() const {
    const std::lock_guard lock(mutex_);
    return allocating_scans_;
  }

  // How old the oldest sample was when it was pushed.
  std::int64_t greatest_age_ns() const { return greatest_age_ns_; }

  // How many more samples are taken until more room is given; room() tells it when `tells_room`.
  void set_room(std::size_t samples) { room_ = samples; }

 private:
  static constexpr std::size_t kCapacity = 1U << 18U;
  static FakeHost& self(void* context) { return *static_cast<FakeHost*>(context); }

  static std::int32_t push(void* context, const dwell_sample* samples, std::size_t count) {
    FakeHost& me = self(context);
    const std::lock_guard lock(me.mutex_);
    const std::int64_t now_ns = driver::raw_ns();
    for (std::size_t i = 0; i < count; ++i)
      me.greatest_age_ns_ = std::max<std::int64_t>(me.greatest_age_ns_, now_ns - samples[i].t_ns);
    const bool refused = me.behind_.push != nullptr ? me.behind_.push(me.behind_.context, samples, count) == 0
                                                    : count > me.room_ || me.samples_.size() + count > kCapacity;
    if (refused) {
      ++me.refused_;
      return 0;
    }
    const std::size_t allocations = allocations_of_this_thread();
    if (me.behind_.push == nullptr) me.room_ -= count;
    me.samples_.insert(me.samples_.end(), samples, samples + count);
    me.scans_.push_back(count);
    if (allocations != me.allocations_ && !me.told_ && me.scans_.size() > 20) ++me.allocating_scans_;
    me.told_ = false;
    me.allocations_ = allocations_of_this_thread();  // the host's own are none of the driver's
    return 1;
  }
  static void state(void* context, std::int32_t channel, dwell_fault fault, const char* reason) {
    FakeHost& me = self(context);
    const std::lock_guard lock(me.mutex_);
    if (me.behind_.state != nullptr) me.behind_.state(me.behind_.context, channel, fault, reason);
    me.told_ = true;
    ++me.states_told_;
    for (int i = 0; i < 16; ++i) {
      const auto index = static_cast<std::uint16_t>(10 + i);
      if (channel < 0 || channel == index) me.states_[index] = {fault, reason == nullptr ? "" : reason};
    }
  }
  static void count(void* context, dwell_fault fault, std::uint64_t occurrences) {
    FakeHost& me = self(context);
    if (me.behind_.count != nullptr) me.behind_.count(me.behind_.context, fault, occurrences);
    me.told_ = true;
    me.counts_.at(static_cast<std::size_t>(fault)) += static_cast<int>(occurrences);
  }
  static void log(void* context, dwell_level level, const char* message) {
    FakeHost& me = self(context);
    const std::lock_guard lock(me.mutex_);
    if (me.behind_.log != nullptr) me.behind_.log(me.behind_.context, level, message);
    me.told_ = true;
    me.logged_.emplace_back(message);
  }
  static void turn(void* context) {
    FakeHost& me = self(context);
    if (me.behind_.turn != nullptr) me.behind_.turn(me.behind_.context);
    const std::int64_t now_ns = driver::monotonic_ns();
    if (me.turns_++ > 0) me.longest_pause_ns_ = std::max<std::int64_t>(me.longest_pause_ns_, now_ns - me.last_turn_ns_);
    me.last_turn_ns_ = now_ns;
  }
  static std::size_t room(void* context) {
    const FakeHost& me = self(context);
    return me.behind_.room != nullptr ? me.behind_.room(me.behind_.context) : me.room_.load();
  }

  dwell_host host_{};
  dwell_host behind_{};
  mutable std::mutex mutex_;
  std::vector<dwell_sample> samples_;
  std::vector<std::size_t> scans_;
  std::size_t allocations_ = 0, allocating_scans_ = 0;
  std::atomic<bool> told_ = false;  // a state, a fault or a line of the log since the last scan
  std::map<std::uint16_t, State> states_;
  std::vector<std::string> logged_;
  std::array<std::atomic<int>, 16> counts_{};
  std::atomic<std::size_t> room_{kCapacity};
  std::atomic<std::size_t> refused_{0};
  std::atomic<std::size_t> states_told_{0};
  std::atomic<std::size_t> turns_{0};
  std::atomic<std::int64_t> last_turn_ns_{driver::monotonic_ns()};
  std::atomic<std::int64_t> longest_pause_ns_{0};
  std::atomic<std::int64_t> greatest_age_ns_{INT64_MIN};
};

// One instance of a driver under some host, stopped and destroyed with this object.
class Driven {
 public:
  virtual ~Driven() = default;
  [[nodiscard]] virtual bool exists() const = 0;
  // The last one.
  [[nodiscard]] virtual const std::string& error() const = 0;
  virtual bool start() = 0;
  // Returns how long it took, s.
  virtual double stop() = 0;
};

// Under a FakeHost; declare it after that.
class Instance : public Driven {
 public:
  Instance(const dwell_driver_table& table, const dwell_settings& settings, FakeHost& host) : table_(table) {
    std::array<char, 256> error{};
    instance_ = table.create(&settings, host.host(), error.data(), error.size());
    error_ = error.data();
  }
  ~Instance() override {
    if (instance_ != nullptr) table_.destroy(instance_);
  }
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  bool exists() const override { return instance_ != nullptr; }
  const std::string& error() const override { return error_; }
  bool start() override {
    std::array<char, 256> error{};
    const bool done = table_.start(instance_, error.data(), error.size()) == 0;
    error_ = error.data();
    return done;
  }
  double stop() override {
    const std::int64_t before_ns = driver::monotonic_ns();
    table_.stop(instance_);
    return static_cast<double>(driver::monotonic_ns() - before_ns) * 1e-9;
  }

 private:
  const dwell_driver_table& table_;
  void* instance_ = nullptr;
  std::string error_;
};

// What check reports, one line each: "channel 0, register: …".
inline std::vector<std::string> mistakes_of(const dwell_driver_table& table, const dwell_settings& settings) {
  std::vector<std::string> mistakes;
  table.check(
      &settings,
      [](void* context, std::int32_t channel, const char* key, const char* message) {
        static_cast<std::vector<std::string>*>(context)->push_back(
            (channel < 0 ? std::string("device") : "channel " + std::to_string(channel)) + ", " +
            (key == nullptr ? "" : key) + ": " + message);
      },
      &mistakes);
  return mistakes;
}

struct ProbeResult {
  double raw = 0.0;
  std::int64_t latency_ns = 0;
  std::string error;
};

inline std::map<std::size_t, ProbeResult> probe(const dwell_driver_table& table, const dwell_settings& settings) {
  std::map<std::size_t, ProbeResult> results;
  table.probe(
      &settings,
      [](void* context, std::size_t channel, double raw, std::int64_t latency_ns, const char* error) {
        (*static_cast<std::map<std::size_t, ProbeResult>*>(context))[channel] = {raw, latency_ns,
                                                                                 error == nullptr ? "" : error};
      },
      &results);
  return results;
}

}  // namespace dwell::test
