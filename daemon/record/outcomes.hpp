// What jobs have come to, on the way from the thread that did them to the one that asked for them.
#pragma once

#include <mutex>
#include <utility>
#include <vector>

namespace dwell::record {

// Thread-safe, short lock. A job holds it by a shared_ptr: the thread that asked may be gone when the job is done.
template <class Outcome>
class Outcomes {
 public:
  void put(Outcome outcome) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(outcome));
  }
  // Those since the last call, in their order.
  [[nodiscard]] std::vector<Outcome> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(waiting_, {});
  }

 private:
  std::mutex mutex_;
  std::vector<Outcome> waiting_;
};

}  // namespace dwell::record
