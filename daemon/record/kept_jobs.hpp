// Jobs that must be done in their order, among those of a DiskJobs. One that fails is kept, with those after it, and is
// tried again. So the ledger gets its entries, and no run waits for it.
#pragma once

#include <cstddef>
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
    {
      const std::lock_guard lock(mutex_);
      if (std::exchange(planned_, true)) return;
    }
    thread_.start([this]() -> Result<void> {
      do_all();
      return {};
    });
  }
  // How many wait, are under way or are kept.
  [[nodiscard]] std::size_t size() const {
    const std::lock_guard lock(mutex_);
    return jobs_.size();
  }
  // Why the first of the kept jobs failed when it was tried last; empty: none has failed, or it has been done since.
  [[nodiscard]] std::string refused() const {
    const std::lock_guard lock(mutex_);
    return refused_;
  }

 private:
  // On the jobs' thread. Only here a job leaves the queue, so its place holds while it is done.
  void do_all() {
    for (;;) {
      const Job* job = nullptr;
      {
        const std::lock_guard lock(mutex_);
        planned_ = !jobs_.empty();
        if (jobs_.empty()) return;
        job = &jobs_.front();
      }
      const Result<void> done = (*job)();
      Job over;  // destroyed without the lock: it may hold a file, which then waits for the disk
      const std::lock_guard lock(mutex_);
      refused_ = done ? std::string() : std::string(done.error());
      planned_ = done.has_value();
      if (!done) return;
      over = std::move(jobs_.front());
      jobs_.pop_front();
    }
  }

  DiskJobs& thread_;
  mutable std::mutex mutex_;
  std::deque<Job> jobs_;  // a place in it holds while others are added at the end
  std::string refused_;
  bool planned_ = false;  // do_all() is to come or under way, and takes what is added
};

}  // namespace dwell::record
