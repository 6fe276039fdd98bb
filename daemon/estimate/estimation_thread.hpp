// The thread that turns an Estimator every 10 ms, on absolute deadlines of CLOCK_MONOTONIC, until told to stop.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>

#include "daemon/estimate/estimator.hpp"

namespace dwell {

class EstimationThread {
 public:
  static constexpr std::int64_t kPeriod_ns = 10'000'000;

  // Starts at once; the estimator must outlive this.
  explicit EstimationThread(Estimator& estimator);
  // Ends the run and joins; takes a few turns at most.
  ~EstimationThread();
  EstimationThread(const EstimationThread&) = delete;
  EstimationThread& operator=(const EstimationThread&) = delete;

  // CLOCK_MONOTONIC_RAW, when it last turned; any thread.
  [[nodiscard]] std::int64_t last_turn_ns() const noexcept { return last_turn_ns_.load(std::memory_order_relaxed); }

 private:
  void run();

  Estimator& estimator_;
  std::atomic<bool> stop_{false};
  std::atomic<std::int64_t> last_turn_ns_;
  std::thread thread_;
};

}  // namespace dwell
