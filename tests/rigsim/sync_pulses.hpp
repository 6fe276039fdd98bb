// The rig's sync output: one pulse for each period of the drive while it runs, written to a file as the kernel's
// simulated GPIO chips take it (sim_gpioK/pull). From a thread of its own, as exact as that wakes; a pulse may fail to
// come, or come twice.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <random>
#include <string>
#include <thread>
#include <tl/expected.hpp>

#include "tests/rigsim/server.hpp"
#include "tests/rigsim/sockets.hpp"

namespace rigsim {

struct SyncOptions {
  std::string file;      // empty: no sync output
  double missing = 0.0;  // probability per period of no pulse
  double twice = 0.0;    // … of a second pulse a quarter of a period later
  std::uint64_t seed = 1;
};

class SyncPulses {
 public:
  // Starts, or says why the file cannot be written. The server must outlive this.
  [[nodiscard]] static tl::expected<std::unique_ptr<SyncPulses>, std::string> start(const SyncOptions& options,
                                                                                    Server& server);
  ~SyncPulses();
  SyncPulses(const SyncPulses&) = delete;
  SyncPulses& operator=(const SyncPulses&) = delete;

 private:
  SyncPulses(const SyncOptions& options, Server& server, Fd file);
  void run();
  // Waits until the simulated time has come; false: this is to end.
  bool wait_until(double t_s);
  bool pulse(double at_s, double length_s);
  void level(bool high);

  SyncOptions options_;
  Server& server_;
  Fd file_;
  std::mt19937_64 random_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

// The frequency in the answer to the control line `status`; 0: the drive does not run.
[[nodiscard]] double running_frequency_hz(const std::string& status);

}  // namespace rigsim
