// Does jobs that wait for the disk in the background, one after the other. Unlike JobThread it drops none: the
// destructor waits for all of them.
#pragma once

#include <future>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "daemon/record/result.hpp"

namespace dwell::record {

// Bound to one thread.
class DiskJobs {
 public:
  DiskJobs() = default;
  ~DiskJobs() { settle(); }
  DiskJobs(const DiskJobs&) = delete;
  DiskJobs& operator=(const DiskJobs&) = delete;

  // job() returns a Result<void> and must not throw. It runs on a thread of its own, after all jobs before it.
  template <class Job>
  void start(Job job) {
    last_ = std::async([this, last = last_, job = std::move(job)]() mutable {
              if (const auto before = std::exchange(last, {}); before.valid()) before.wait();
              if (const Result<void> done = job(); !done) {
                const std::lock_guard lock(mutex_);
                failures_.push_back(done.error());
              }
            }).share();
  }
  // Ready when all jobs so far are done; not valid: there were none. Any thread may wait for it.
  [[nodiscard]] std::shared_future<void> done() const { return last_; }
  // Waits until all jobs are done.
  void settle() const {
    if (last_.valid()) last_.wait();
  }
  // The reasons of the jobs that have failed since the last call.
  [[nodiscard]] std::vector<std::string> take_failures() {
    const std::lock_guard lock(mutex_);
    return std::exchange(failures_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> failures_;
  std::shared_future<void> last_;  // waits for all before it
};

}  // namespace dwell::record
