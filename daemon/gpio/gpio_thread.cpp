#include "daemon/gpio/gpio_thread.hpp"

#include <pthread.h>
#include <time.h>

#include "daemon/clock.hpp"

namespace dwell::gpio {

GpioThread::GpioThread(const config::GpioSettings& settings, std::unique_ptr<LineSource> source, Log& log)
    : source_(std::move(source)), panel_(settings, *source_, link_, log) {
  link_.order({}, raw_now_ns());  // starting up is no fault
  turn();
  thread_ = std::thread([this] { run(); });
}

GpioThread::~GpioThread() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

void GpioThread::turn() {
  const ClockPair now = read_clock_pair();
  panel_.turn(now);
  last_turn_ns_.store(now.raw_ns, std::memory_order_relaxed);
}

void GpioThread::run() {
  pthread_setname_np(pthread_self(), "gpio");
  const int longest_ms = panel_.has_inputs() ? 10 : 100;
  // Edges carry the kernel's stamps: taking several at once costs no accuracy, and a line that babbles no processor.
  const timespec gather{0, 500'000};
  while (!stop_.load(std::memory_order_relaxed)) {
    auto waited_for = panel_.waited_for();
    if (poll(waited_for.data(), waited_for.size(), longest_ms) > 0) nanosleep(&gather, nullptr);
    turn();
  }
}

}  // namespace dwell::gpio
