// Makes things on a thread of its own, a few ahead of whoever takes them.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace dwell::record {

// Bound to one thread but for `make`, which its own thread alone calls.
template <class T>
class Ahead {
 public:
  // make: the next thing; nullopt: there is none left, and it is not called again. most: things at most that wait or
  // are being made, so that memory is bounded. Both threads wait for one another without working.
  Ahead(std::function<std::optional<T>()> make, std::size_t most)
      : make_(std::move(make)), most_(most), thread_([this] { run(); }) {}
  // Waits for the thing that is being made.
  ~Ahead() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
  }
  Ahead(const Ahead&) = delete;
  Ahead& operator=(const Ahead&) = delete;

  // The next one; nullopt: there is none left. Throws what `make` has thrown.
  [[nodiscard]] std::optional<T> next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !things_.empty() || done_; });
    if (things_.empty()) {
      if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
      return std::nullopt;
    }
    std::optional<T> thing(std::move(things_.front()));
    things_.pop_front();
    lock.unlock();
    changed_.notify_all();
    return thing;
  }

 private:
  // Before a thing is made, so that there are never more of them. false: shall end.
  bool waits_for_room() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return things_.size() < most_ || stop_; });
    return !stop_;
  }

  void run() {
    try {
      while (waits_for_room()) {
        std::optional<T> thing = make_();
        if (!thing) break;
        {
          const std::lock_guard lock(mutex_);
          things_.push_back(std::move(*thing));
        }
        changed_.notify_all();
      }
    } catch (...) {
      const std::lock_guard lock(mutex_);
      failed_ = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    done_ = true;
    changed_.notify_all();
  }

  const std::function<std::optional<T>()> make_;
  const std::size_t most_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<T> things_;
  std::exception_ptr failed_;
  bool done_ = false, stop_ = false;
  std::thread thread_;  // last: it uses all the rest
};

}  // namespace dwell::record
