// Does jobs that wait for the disk in the background, one after the other. Unlike JobThread it drops none: the
// destructor waits for all of them.
#pragma once

#include <chrono>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
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

  // job() returns a Result<void> and must not throw; take_failures() has the reason of one that failed. It runs on a
  // thread of its own, after all jobs before it. If the system gives no thread, it is done before start() returns.
  template <class Job>
  void start(Job job) {
    // Copied, so that the job is still here if no thread can be begun: std::async loses what is moved into it.
    auto work = [this, last = last_, job = std::make_shared<Job>(std::move(job))]() mutable {
      if (const auto before = std::exchange(last, {}); before.valid()) before.wait();
      if (const Result<void> done = (*job)(); !done) failed(done.error());
    };
    try {
      last_ = std::async(std::launch::async, work).share();
    } catch (const std::system_error&) {
      work();
    }
  }
  // Whether all jobs so far are done.
  [[nodiscard]] bool idle() const {
    return !last_.valid() || last_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  // Waits until all jobs are done.
  void settle() const {
    if (last_.valid()) last_.wait();
  }
  // Adds the reason why a part of a job failed. Any thread.
  void failed(std::string why) {
    const std::lock_guard lock(mutex_);
    failures_.push_back(std::move(why));
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
