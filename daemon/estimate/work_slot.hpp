// Hands one job at a time from the thread that knows what is to be done to the one that has the time, and the finished
// job back. Neither waits for the other; the worker alone waits for work.
//
// Thread-safe as each member says: "giver" is the thread that gives work, "worker" the one that does it. The job
// belongs to the giver while the slot is free or done, to the worker in between.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>
#include <semaphore>
#include <utility>

namespace dwell {

template <class Job>
class WorkSlot {
 public:
  // Giver: whether a job may be put. Real-time safe.
  [[nodiscard]] bool free() const noexcept { return state_.load(std::memory_order_acquire) == State::free; }
  // Giver, if free(): a job to be done. Wakes the worker.
  void put(Job job) {
    job_.emplace(std::move(job));
    state_.store(State::waits, std::memory_order_release);
    bell_.release();
  }
  // Giver: takes the finished job and frees the slot; none: no job is finished.
  [[nodiscard]] std::optional<Job> collect() {
    if (state_.load(std::memory_order_acquire) != State::done) return std::nullopt;
    std::optional<Job> job = std::exchange(job_, std::nullopt);
    state_.store(State::free, std::memory_order_release);
    return job;
  }

  // Worker: does what waits, by do_it(job); false: nothing does.
  template <class Do>
  bool work(const Do& do_it) {
    if (state_.load(std::memory_order_acquire) != State::waits) return false;
    do_it(*job_);
    state_.store(State::done, std::memory_order_release);
    return true;
  }
  // Worker: sleeps until a job is put or somebody rings.
  void wait() { bell_.acquire(); }
  // Any thread.
  void ring() noexcept { bell_.release(); }

 private:
  enum class State : std::uint8_t { free, waits, done };

  std::optional<Job> job_;
  std::atomic<State> state_{State::free};
  std::counting_semaphore<> bell_{0};
};

}  // namespace dwell
