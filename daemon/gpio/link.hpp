// Between the GPIO thread and the others: edges to the estimation thread, the lamps' order from the event loop, how the
// lines stand to whoever asks. Bounded; only status() takes a lock, which no thread holds for long.
#pragma once

#include <array>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "core/stream/record.hpp"
#include "daemon/gpio/lamps.hpp"

namespace dwell::gpio {

enum class Function : std::uint8_t { interlock, sync, ready, fault };
inline constexpr std::size_t kFunctions = 4;
inline constexpr std::array<const char*, kFunctions> kFunctionNames{"interlock", "sync", "ready", "fault"};

struct LineStatus {
  bool configured = false;
  bool works = false;
  std::string reason;         // why it does not
  std::optional<bool> level;  // as it counts; none: not known
  std::uint64_t edges = 0;    // inputs: those that counted
  std::uint64_t bounces = 0;  // inputs: those that did not
  std::uint64_t lost = 0;     // inputs: edges that came but did not get into the stream, and gaps that the kernel told
};
using Status = std::array<LineStatus, kFunctions>;  // by Function

class Link {
 public:
  static constexpr std::size_t kEdges = 1024;

  // The GPIO thread. push: false: no room.
  bool push(const Record& edge) noexcept { return edges_.push(edge); }
  [[nodiscard]] bool has_room() const noexcept { return edges_.write_available() > 0; }
  // Every edge before this instant (CLOCK_MONOTONIC_RAW) has been pushed.
  void seen_to(std::int64_t t_ns) noexcept { seen_to_ns_.store(t_ns, std::memory_order_release); }
  void tell(const Status& status) {
    const std::lock_guard lock(mutex_);
    status_ = status;
  }

  // The estimation thread; ask seen_to_ns() before pop(). INT64_MIN: there are no inputs.
  [[nodiscard]] std::int64_t seen_to_ns() const noexcept { return seen_to_ns_.load(std::memory_order_acquire); }
  bool pop(Record& out) noexcept { return edges_.pop(out); }
  void late() noexcept { late_.fetch_add(1, std::memory_order_relaxed); }

  // The event loop.
  void order(const LampOrder& order, std::int64_t now_ns) noexcept {
    order_.store(static_cast<std::uint8_t>((order.ready ? 1 : 0) | (order.fault ? 2 : 0)), std::memory_order_relaxed);
    ordered_ns_.store(now_ns, std::memory_order_relaxed);
  }

  // Any thread.
  [[nodiscard]] LampOrder order() const noexcept {
    const std::uint8_t order = order_.load(std::memory_order_relaxed);
    return {(order & 1) != 0, (order & 2) != 0};
  }
  [[nodiscard]] std::int64_t ordered_ns() const noexcept { return ordered_ns_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t late_edges() const noexcept { return late_.load(std::memory_order_relaxed); }
  [[nodiscard]] Status status() const {
    const std::lock_guard lock(mutex_);
    return status_;
  }

 private:
  boost::lockfree::spsc_queue<Record, boost::lockfree::capacity<kEdges>> edges_;
  std::atomic<std::int64_t> seen_to_ns_{INT64_MIN};
  std::atomic<std::int64_t> ordered_ns_{INT64_MIN / 2};
  std::atomic<std::uint64_t> late_{0};
  std::atomic<std::uint8_t> order_{0};
  mutable std::mutex mutex_;
  Status status_;
};

}  // namespace dwell::gpio
