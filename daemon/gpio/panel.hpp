// The rig's GPIO lines as the service uses them, in virtual time: turn() is one pass at the instant it is given, Thread
// calls it.
//
// A line that cannot be had, or breaks, is told once and tried again every few seconds; the service runs on without
// what it is for. An interlock that breaks after it had worked counts as lost. Bound to one thread.
#pragma once

#include <poll.h>

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/gpio/clock_map.hpp"
#include "daemon/gpio/edge_filter.hpp"
#include "daemon/gpio/line.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/log/log.hpp"
#include "daemon/log/throttle.hpp"

namespace dwell::gpio {

class Panel {
 public:
  static constexpr std::int64_t kRetry_ns = 2'000'000'000;
  static constexpr std::int64_t kProbe_ns = 1'000'000'000;  // lines are read or set this often: a chip may go unheard
  // An edge may be told so much after its instant: that lies between the interrupt and the thread behind it.
  static constexpr std::int64_t kLateness_ns = 10'000'000;

  // All must outlive this. No line is touched yet.
  Panel(const config::GpioSettings& settings, LineSource& source, Link& link, Log& log);
  // Darkens the lamps.
  ~Panel();
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;

  // Opens what is not open, hands in the edges that have come, sets the lamps. The first one hands in the interlock's
  // level.
  void turn(const ClockPair& now);

  [[nodiscard]] bool has_inputs() const noexcept;
  // What to wait for until the next turn; by Function, -1 where there is nothing.
  [[nodiscard]] std::array<pollfd, 2> waited_for() const noexcept;

 private:
  struct Input {
    std::unique_ptr<InputLine> line;   // null: not open
    std::optional<EdgeFilter> filter;  // none: rising edges are taken as they come
    std::int64_t probe_ns = 0;         // CLOCK_MONOTONIC
    bool gap = false;                  // edges were lost before the next one
    bool untold = false;               // the last edge found no room: the stream knows another level
  };
  struct Held {
    const config::GpioLine* line = nullptr;  // null: not configured
    Input input;                             // of interlock and sync
    std::unique_ptr<OutputLine> output;      // of the lamps; null: not open
    std::int64_t retry_ns = INT64_MIN;
    [[nodiscard]] bool open() const noexcept { return input.line != nullptr || output != nullptr; }
  };

  void open(Function function);
  void fail(Function function, const std::string& reason);
  void take(Function function);
  void probe(Function function);
  void tell_edge(Function function, std::int64_t monotonic_ns, bool level);
  void count_loss(Function function);
  void light();

  Held& held(Function function) noexcept { return held_[static_cast<std::size_t>(function)]; }
  Input& input(Function function) noexcept { return held(function).input; }
  LineStatus& status(Function function) noexcept { return status_[static_cast<std::size_t>(function)]; }

  const config::GpioSettings settings_;
  LineSource& source_;
  Link& link_;
  Log& log_;
  std::array<Throttle, 2> interlock_lines_;  // by level: a loss is told however lately it returned
  ClockMap clocks_;
  std::int64_t previous_raw_ns_ = INT64_MIN;  // when edges were read before
  std::int64_t lamps_anew_ns_ = INT64_MIN;    // when they are set though nothing has changed
  std::array<Held, kFunctions> held_;
  Status status_;
};

// Darkens both lamps, for the time after the service has ended; the reasons for those that could not be. Some chips
// hold the last level when a process dies.
[[nodiscard]] std::vector<std::string> lamps_off(const config::GpioSettings& settings, LineSource& source);

}  // namespace dwell::gpio
