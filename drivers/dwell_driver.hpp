// A driver as a C++ class: this header turns it into the C table of dwell_driver.h. Header-only; include it in one file
// of the plugin, write the class, and end the file with DWELL_DRIVER(Class, "name", "version", "help", keys).
//
//   class Sine {
//    public:
//     Sine(const Settings& settings, const Host& host);   // copies what it needs; throws to refuse; touches no device
//     void run(Stop& stop);                               // delivers until stop.requested(); on a thread of its own
//     static void describe(const Settings&, dwell_traits&);  // how old samples may be, and what else is known
//     static void check(const Settings&, Report&);        // optional: mistakes the key schema cannot see
//     static void probe(const Settings&, Probed&);        // optional: reads every channel once
//   };
//
// The wrapper owns the thread and lets no exception out. If run throws, all channels are marked disconnected with the
// exception's text and run is called again after a second; if it returns, the thread stays alive, idle, until stop.
// Unless said otherwise nothing here is thread-safe; Host::push, room, count and turn are real-time safe.
#pragma once

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

#include "dwell_driver.h"

namespace dwell::driver {

// ---- time ----------------------------------------------------------------------------------------------------------

[[nodiscard]] inline std::int64_t clock_ns(clockid_t clock) noexcept {
  timespec now{};
  ::clock_gettime(clock, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}
// What samples are stamped with.
[[nodiscard]] inline std::int64_t raw_ns() noexcept { return clock_ns(CLOCK_MONOTONIC_RAW); }
// What waits are measured against.
[[nodiscard]] inline std::int64_t monotonic_ns() noexcept { return clock_ns(CLOCK_MONOTONIC); }

[[nodiscard]] constexpr std::int64_t to_ns(double seconds) noexcept { return static_cast<std::int64_t>(seconds * 1e9); }

// ---- key schema ----------------------------------------------------------------------------------------------------

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

constexpr dwell_key text_key(dwell_scope scope, const char* name, const char* choices, const char* help) {
  return {name, scope, DWELL_STRING, 0, 1.0, 0.0, choices, "", help};
}
constexpr dwell_key flag_key(dwell_scope scope, const char* name, const char* help) {
  return {name, scope, DWELL_BOOLEAN, 0, 1.0, 0.0, nullptr, "", help};
}
// Inclusive bounds; kUnbounded where there is none.
constexpr dwell_key integer_key(dwell_scope scope, const char* name, double minimum, double maximum, const char* unit,
                                const char* help) {
  return {name, scope, DWELL_INTEGER, 0, minimum, maximum, nullptr, unit, help};
}
constexpr dwell_key real_key(dwell_scope scope, const char* name, double minimum, double maximum, const char* unit,
                             const char* help) {
  return {name, scope, DWELL_REAL, 0, minimum, maximum, nullptr, unit, help};
}
constexpr dwell_key required(dwell_key key) {
  key.required = 1;
  return key;
}

// A struct that begins with its size, as far as the other side's header and ours both know it; beyond it is zero.
template <class Sized>
[[nodiscard]] Sized known_part(const Sized& given) noexcept {
  Sized known{};
  std::memcpy(&known, &given, std::min<std::size_t>(given.size, sizeof known));
  return known;
}

// ---- settings ------------------------------------------------------------------------------------------------------

// The keys of one table of the rig file. A view: valid during the call it was handed to.
class Entries {
 public:
  Entries(const dwell_entry* entries, std::size_t count) : entries_(count == 0 ? nullptr : entries, count) {}

  // The value of a key; none: not given, or not of this kind. T: bool, an integer, double, std::string,
  // std::string_view.
  template <class T>
  [[nodiscard]] std::optional<T> get(std::string_view key) const {
    for (const dwell_entry& entry : entries_)
      if (key == entry.key) return as<T>(entry);
    return std::nullopt;
  }
  template <class T>
  [[nodiscard]] T get(std::string_view key, T otherwise) const {
    return get<T>(key).value_or(std::move(otherwise));
  }
  [[nodiscard]] bool has(std::string_view key) const {
    return std::any_of(entries_.begin(), entries_.end(), [&](const dwell_entry& entry) { return key == entry.key; });
  }

 private:
  template <class T>
  static std::optional<T> as(const dwell_entry& entry) {
    if constexpr (std::is_same_v<T, bool>) {
      if (entry.type == DWELL_BOOLEAN) return entry.boolean != 0;
    } else if constexpr (std::is_integral_v<T>) {
      const auto value = static_cast<T>(entry.integer);
      if (entry.type == DWELL_INTEGER && static_cast<std::int64_t>(value) == entry.integer) return value;
    } else if constexpr (std::is_same_v<T, double>) {
      if (entry.type == DWELL_REAL) return entry.real;
      if (entry.type == DWELL_INTEGER) return static_cast<double>(entry.integer);
    } else {
      if (entry.type == DWELL_STRING && entry.string != nullptr) return T(entry.string);
    }
    return std::nullopt;
  }

  std::span<const dwell_entry> entries_;
};

struct ChannelSettings : Entries {
  explicit ChannelSettings(const dwell_channel& c) : Entries(c.entries, c.entry_count), name(c.name), index(c.index) {}
  std::string_view name;
  std::uint16_t index;  // what dwell_sample::channel must carry
};

// One [[device]] with its channels. A view: valid during the call it was handed to.
class Settings : public Entries {
 public:
  explicit Settings(const dwell_settings& s) : Entries(s.entries, s.entry_count), settings_(known_part(s)) {
    for (std::size_t i = 0; i < s.channel_count; ++i) channels_.emplace_back(s.channels[i]);
  }
  [[nodiscard]] std::string_view device() const { return settings_.device; }
  [[nodiscard]] const std::vector<ChannelSettings>& channels() const { return channels_; }
  // A path given in the rig file: a relative one starts at the rig file's folder.
  [[nodiscard]] std::string path(std::string_view given) const {
    const std::string_view folder = settings_.directory == nullptr ? "" : settings_.directory;
    if (given.empty() || given.front() == '/' || folder.empty()) return std::string(given);
    return std::string(folder) + "/" + std::string(given);
  }

 private:
  dwell_settings settings_;
  std::vector<ChannelSettings> channels_;
};

// ---- host ----------------------------------------------------------------------------------------------------------

// What the host offers, see dwell_host. A copy stays valid as long as the driver.
class Host {
 public:
  explicit Host(const dwell_host& host) : host_(known_part(host)) {}
  // One scan, entered whole (true) or refused whole.
  bool push(std::span<const dwell_sample> scan) const noexcept {
    return host_.push(host_.context, scan.data(), scan.size()) != 0;
  }
  // Samples that push is sure to take now; a host that does not tell is taken to have room.
  [[nodiscard]] std::size_t room() const noexcept {
    return host_.room == nullptr ? std::numeric_limits<std::size_t>::max() : host_.room(host_.context);
  }
  void state(int channel, dwell_fault fault, const char* reason = nullptr) const noexcept {
    host_.state(host_.context, channel, fault, reason);
  }
  void count(dwell_fault fault, std::uint64_t occurrences = 1) const noexcept {
    if (occurrences > 0) host_.count(host_.context, fault, occurrences);
  }
  void log(dwell_level level, const std::string& message) const noexcept {
    host_.log(host_.context, level, message.c_str());
  }
  void turn() const noexcept { host_.turn(host_.context); }

 private:
  dwell_host host_;
};

// ---- stop ----------------------------------------------------------------------------------------------------------

// Whether the driver shall end, and waits that end with it. The waits report the thread as alive by themselves; a loop
// that does not wait calls turn(). request() may be called from any thread.
class Stop {
 public:
  enum class Wait : std::uint8_t { ready, timeout, stopped };

  explicit Stop(const Host* host) : host_(host), event_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    if (event_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd");
  }
  ~Stop() { ::close(event_); }
  Stop(const Stop&) = delete;
  Stop& operator=(const Stop&) = delete;

  [[nodiscard]] bool requested() const noexcept { return requested_.load(std::memory_order_acquire); }

  void request() noexcept {
    requested_.store(true, std::memory_order_release);
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(event_, &one, sizeof one);
  }

  void turn() const noexcept {
    if (host_ != nullptr) host_->turn();
  }

  // Waits until an instant of CLOCK_MONOTONIC, exactly; false: shall end. May take up to kSlice_ns longer to see a
  // stop.
  bool sleep_until(std::int64_t deadline_ns) const noexcept {
    turn();
    while (!requested()) {
      const std::int64_t now_ns = monotonic_ns();
      if (now_ns >= deadline_ns) return true;
      const std::int64_t until_ns = std::min(deadline_ns, now_ns + kSlice_ns);
      const timespec until{until_ns / 1'000'000'000, until_ns % 1'000'000'000};
      ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
      if (until_ns < deadline_ns) turn();
    }
    return false;
  }
  bool sleep_for(std::int64_t span_ns) const noexcept { return sleep_until(monotonic_ns() + span_ns); }

  // Waits until a descriptor has one of `events` (or an error, which counts as ready), a stop, or the instant.
  Wait wait(int descriptor, short events, std::int64_t deadline_ns) const noexcept {
    while (!requested()) {
      turn();
      const std::int64_t left_ns = deadline_ns - monotonic_ns();
      const std::int64_t slice_ns = std::clamp<std::int64_t>(left_ns, 0, kSlice_ns);
      const timespec slice{0, slice_ns};
      pollfd descriptors[] = {{descriptor, events, 0}, {event_, POLLIN, 0}};
      ::ppoll(descriptors, 2, &slice, nullptr);
      if (descriptors[1].revents != 0) break;
      if (descriptors[0].revents != 0) return Wait::ready;
      if (left_ns <= slice_ns) return Wait::timeout;
    }
    return Wait::stopped;
  }

 private:
  static constexpr std::int64_t kSlice_ns = 200'000'000;  // well within what turn() and stop are allowed
  const Host* host_;
  int event_;
  std::atomic<bool> requested_{false};
};

// ---- check and probe -----------------------------------------------------------------------------------------------

// Receives the mistakes that check finds.
class Report {
 public:
  Report(dwell_report report, void* context) : report_(report), context_(context) {}
  void device(const char* key, const std::string& message) { report_(context_, -1, key, message.c_str()); }
  // `channel`: index into Settings::channels().
  void channel(std::size_t channel, const char* key, const std::string& message) {
    report_(context_, static_cast<std::int32_t>(channel), key, message.c_str());
  }

 private:
  dwell_report report_;
  void* context_;
};

// Receives the results of probe; `channel`: index into Settings::channels().
class Probed {
 public:
  Probed(dwell_probed probed, void* context) : probed_(probed), context_(context) {}
  void value(std::size_t channel, double raw, std::int64_t latency_ns) {
    probed_(context_, channel, raw, latency_ns, nullptr);
  }
  void error(std::size_t channel, const std::string& message) { probed_(context_, channel, 0.0, 0, message.c_str()); }

 private:
  dwell_probed probed_;
  void* context_;
};

}  // namespace dwell::driver

#include "dwell_driver_instance.hpp"

// Exports the plugin's one symbol. `keys`: an array of dwell_key, or a span of one.
#define DWELL_DRIVER(Class, name, version, help, keys)                                                   \
  extern "C" __attribute__((visibility("default"))) const dwell_driver_table* dwell_driver(void) {       \
    static const dwell_driver_table table = dwell::driver::make_table<Class>(name, version, help, keys); \
    return &table;                                                                                       \
  }
