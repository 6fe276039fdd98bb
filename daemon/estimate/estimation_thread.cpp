#include "daemon/estimate/estimation_thread.hpp"

#include <pthread.h>

#include "daemon/clock.hpp"

namespace dwell {

EstimationThread::EstimationThread(Estimator& estimator)
    : estimator_(estimator), last_turn_ns_(raw_now_ns()), thread_([this] { run(); }) {}

EstimationThread::~EstimationThread() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void EstimationThread::run() {
  pthread_setname_np(pthread_self(), "estimate");
  // RAW cannot be slept on; the two clocks differ by a slew of 500 ppm at most, nothing at 10 ms.
  std::int64_t deadline_ns = read_clock_ns(CLOCK_MONOTONIC);
  std::uint64_t skipped = 0;
  while (!stop_.load(std::memory_order_relaxed)) {
    const std::int64_t now_ns = raw_now_ns();
    estimator_.turn(now_ns, utc_now_ns(), skipped);
    last_turn_ns_.store(now_ns, std::memory_order_relaxed);
    deadline_ns += kPeriod_ns;
    const std::int64_t behind_ns = read_clock_ns(CLOCK_MONOTONIC) - deadline_ns;
    skipped = behind_ns > 0 ? static_cast<std::uint64_t>(behind_ns / kPeriod_ns) : 0;
    deadline_ns += static_cast<std::int64_t>(skipped) * kPeriod_ns;
    const timespec until{static_cast<std::time_t>(deadline_ns / 1'000'000'000),
                         static_cast<long>(deadline_ns % 1'000'000'000)};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  }
  estimator_.finish(raw_now_ns(), utc_now_ns());
}

}  // namespace dwell
