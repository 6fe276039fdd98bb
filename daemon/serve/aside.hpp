// Does work for the event loop on a thread of its own, one piece after the other, at the lowest priority: a disk that
// hangs must not hold up the loop, and no client takes processor or disk from the measurement. The thread starts with
// the first piece. Bound to the loop's thread.
#pragma once

#include <cstdint>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "daemon/record/job_thread.hpp"
#include "daemon/record/low_priority.hpp"
#include "daemon/serve/event_loop.hpp"

namespace dwell {

class Aside {
 public:
  Aside(EventLoop& loop, std::string thread) : thread_name_(std::move(thread)) { shared_->loop = &loop; }
  ~Aside() { close(); }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

  // Does `work`, which must not throw and owns what it uses, then `then` with its outcome on the loop. After close()
  // both are dropped at once: kept, a `then` that holds the owner of this would keep both for ever.
  template <class Work, class Then>
  void ask(Work work, Then then) {
    if (shared_->loop == nullptr) return;
    using Outcome = decltype(work());
    if (!thread_) thread_.emplace(thread_name_);
    const std::uint64_t number = next_++;
    const bool posted = thread_->post([shared = shared_, number, work = std::move(work)](const auto&) mutable {
      record::lower_priority();
      auto outcome = std::make_shared<Outcome>(work());
      const std::lock_guard lock(shared->mutex);
      if (shared->loop == nullptr) return;
      shared->loop->post([shared, number, outcome] {
        auto asker = shared->waiting.extract(number);
        if (!asker.empty()) asker.mapped()(outcome.get());
      });
    });
    // The outcome comes through the loop, so not before this returns.
    if (posted)
      shared_->waiting.emplace(number, [then = std::move(then)](void* outcome) mutable {
        then(std::move(*static_cast<Outcome*>(outcome)));
      });
  }

  // Destroys `thing`, which may take long, on the thread, after all that was asked for before; here where the thread
  // takes no more work or there is no memory.
  template <class Thing>
  void drop(std::shared_ptr<Thing> thing) noexcept {
    try {
      if (thread_) (void)thread_->post([thing = std::move(thing)](const auto&) {});
    } catch (const std::exception&) {
    }
  }

  // Forgets what was asked for: no `then` is called any more.
  void close() {
    {
      const std::lock_guard lock(shared_->mutex);
      shared_->loop = nullptr;
    }
    std::exchange(shared_->waiting, {}).clear();
  }

 private:
  // Outlives this where the thread hangs.
  struct Shared {
    std::mutex mutex;
    EventLoop* loop = nullptr;  // null: closed. Changed by the loop's thread alone, which reads it without the lock
    // What waits for an outcome, by number. Used by the loop's thread alone: what it holds must not be destroyed on
    // another one.
    std::map<std::uint64_t, std::function<void(void*)>> waiting;
  };

  const std::shared_ptr<Shared> shared_ = std::make_shared<Shared>();
  const std::string thread_name_;
  std::uint64_t next_ = 0;  // number of the next piece
  std::optional<record::JobThread> thread_;
};

}  // namespace dwell
