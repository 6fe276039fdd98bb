// Simulated time as a straight line of the host's clock; a change of the drift keeps it continuous.
#pragma once

#include <cstdint>
#include <mutex>

namespace rigsim {

// May be used from any thread.
class SimulatedClock {
 public:
  // 0 s at start_ns of the host's clock.
  SimulatedClock(std::int64_t start_ns, double drift_ppm) : from_ns_(start_ns), rate_(1.0 + 1e-6 * drift_ppm) {}

  // Simulated seconds at an instant of the host's clock.
  [[nodiscard]] double at(std::int64_t clock_ns) const {
    const std::scoped_lock lock(mutex_);
    return from_s_ + static_cast<double>(clock_ns - from_ns_) * 1e-9 * rate_;
  }

  void set_drift(std::int64_t clock_ns, double drift_ppm) {
    const std::scoped_lock lock(mutex_);
    from_s_ += static_cast<double>(clock_ns - from_ns_) * 1e-9 * rate_;
    from_ns_ = clock_ns;
    rate_ = 1.0 + 1e-6 * drift_ppm;
  }

 private:
  mutable std::mutex mutex_;
  std::int64_t from_ns_;
  double from_s_ = 0.0;
  double rate_;
};

}  // namespace rigsim
