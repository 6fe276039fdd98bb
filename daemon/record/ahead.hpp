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

// Bound to one thread. `make` runs on the object's own thread only.
template <class T>
class Ahead {
 public:
  // make: returns the next thing; nullopt: none is left, and it is not called again. most: the largest number of things
  // that wait or are being made; bounds the memory. A thread that must wait sleeps.
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

  // The next thing; waits for it. nullopt: none is left. If `make` threw, throws that once, after all things made
  // before.
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
  // Waits until one more thing may be made. false: the object is being destroyed.
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
