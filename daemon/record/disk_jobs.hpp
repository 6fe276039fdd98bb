// Jobs that wait for the disk beside the thread that gives them, one after the other.
#pragma once

#include <future>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "daemon/record/keys.hpp"

namespace dwell::record {

// Bound to one thread, which alone gives jobs and asks.
class Beside {
 public:
  Beside() = default;
  ~Beside() { settle(); }
  Beside(const Beside&) = delete;
  Beside& operator=(const Beside&) = delete;

  // job(): a Result<void>; must not throw. It runs when those before it are done.
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
  // For other threads: ready when all jobs so far are done; not valid: there were none.
  [[nodiscard]] std::shared_future<void> done() const { return last_; }
  // Waits until all jobs are done.
  void settle() const {
    if (last_.valid()) last_.wait();
  }
  // Why jobs have failed since the last call.
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
