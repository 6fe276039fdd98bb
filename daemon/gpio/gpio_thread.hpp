// The thread that turns a Panel: whenever edges come, and at least every 10 ms where there are inputs. Everything that
// GPIO is to the service, in one object; without a configured line there is none.
#pragma once

#include <atomic>
#include <memory>
#include <thread>

#include "config/rig_file.hpp"
#include "daemon/gpio/link.hpp"
#include "daemon/gpio/panel.hpp"

namespace dwell::gpio {

class GpioThread {
 public:
  // The lines are opened and the interlock's level lies in the link before this returns. The log must outlive this.
  GpioThread(const config::GpioSettings& settings, std::unique_ptr<LineSource> source, Log& log);
  // Darkens the lamps.
  ~GpioThread();
  GpioThread(const GpioThread&) = delete;
  GpioThread& operator=(const GpioThread&) = delete;

  [[nodiscard]] Link& link() noexcept { return link_; }
  [[nodiscard]] const Link& link() const noexcept { return link_; }
  // CLOCK_MONOTONIC_RAW, when it last turned; any thread.
  [[nodiscard]] std::int64_t last_turn_ns() const noexcept { return last_turn_ns_.load(std::memory_order_relaxed); }

 private:
  void turn();
  void run();

  std::unique_ptr<LineSource> source_;
  Link link_;
  Panel panel_;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> last_turn_ns_{0};
  std::thread thread_;
};

}  // namespace dwell::gpio
