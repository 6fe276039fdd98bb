// Jobs that must be done in their order, on a thread of their own. One that fails is kept, with those after it, and is
// tried again. So the ledger gets its entries, and no run waits for it.
#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <utility>

#include "daemon/record/disk_jobs.hpp"
#include "daemon/record/result.hpp"

namespace dwell::record {

// Bound to one thread.
class KeptJobs {
 public:
  using Job = std::function<Result<void>()>;
  // Does them among the jobs of `thread`, which outlives it.
  explicit KeptJobs(DiskJobs& thread) : thread_(thread) {}

  // Does the job after all that are kept. Those are tried first.
  void add(Job job) {
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(std::move(job));
    }
    again();
  }
  // Tries what is kept.
  void again() {
    thread_.start([this]() -> Result<void> {
      do_all();
      return {};
    });
  }
  // Whether jobs wait, are under way or are kept.
  [[nodiscard]] bool any() const {
    const std::lock_guard lock(mutex_);
    return !jobs_.empty();
  }
  // Why the first of the kept jobs failed when it was tried last; empty: none has failed, or it has been done since.
  [[nodiscard]] std::string refused() const {
    const std::lock_guard lock(mutex_);
    return refused_;
  }

 private:
  // The first one that waits, in its place; nullptr: none.
  [[nodiscard]] const Job* first() const {
    const std::lock_guard lock(mutex_);
    return jobs_.empty() ? nullptr : &jobs_.front();
  }
  // On the jobs' thread. Only here a job leaves the queue, so its place holds while it is done.
  void do_all() {
    while (const Job* job = first()) {
      const Result<void> done = (*job)();
      const std::lock_guard lock(mutex_);
      refused_ = done ? std::string() : std::string(done.error());
      if (!done) return;
      jobs_.pop_front();
    }
  }

  DiskJobs& thread_;
  mutable std::mutex mutex_;
  std::deque<Job> jobs_;  // a place in it holds while others are added at the end
  std::string refused_;
};

}  // namespace dwell::record
