// Carries records, and what is published between them, in order from the estimation thread to the recorder.
// Bounded; neither side ever waits for the other.
//
// If the recorder falls behind until the ring is full, records are dropped until half of the ring is free again. The
// reader finds one gap in their place, with their count.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/result/dwell.hpp"
#include "core/stream/record.hpp"
#include "daemon/record/stream_sink.hpp"

namespace dwell::record {

// Size of the ring, in records: 6 s of the stream, so that nothing is lost while a disk stalls for 5 s. At least 65 536
// (2 MiB, for a rig whose rates are not known), at most 8 388 608 (256 MiB, a quarter of what the unit allows the
// service). rate_hz: samples per second, all channels together; a thousand other records a second are added.
[[nodiscard]] std::size_t ring_records(double rate_hz) noexcept;

// A result on its way, or a change of state.
struct RingResult {
  std::uint64_t position = 0;  // of a result
  bool final = false;
  std::shared_ptr<const Dwell> dwell;  // null: it is `model`
  ModelResult model;
  std::optional<StateChange> change;  // then it is no result; `dwell` is as it stood after the change
  std::uint64_t after = 0;            // records that entered the ring before it
};

// push() belongs to the estimation thread, drain() to the recorder's; the counters may be read on any thread.
class RecordRing {
 public:
  // Most results that wait; the dwells are shared, not copied. Further ones are lost, and counted.
  static constexpr std::size_t kResults = 256;

  explicit RecordRing(std::size_t records);
  ~RecordRing();
  RecordRing(const RecordRing&) = delete;
  RecordRing& operator=(const RecordRing&) = delete;

  // Real-time safe.
  void push(const Record& record) noexcept;
  void push(std::uint64_t position, bool final, std::shared_ptr<const Dwell> dwell) noexcept;
  void push(std::uint64_t position, ModelResult model) noexcept;
  void push(const StateChange& change, std::shared_ptr<const Dwell> after) noexcept;

  struct Reader {
    std::function<void(const Record&)> record;
    std::function<void(const RingResult&)> result;
    std::function<void(std::uint64_t lost)> gap;  // `lost` records are missing here
  };
  // Hands over all waiting records and results, in order.
  void drain(const Reader& reader);

  [[nodiscard]] std::size_t capacity() const noexcept { return capacity_; }
  // How many results were lost since this was called last. Bound to the recorder's thread.
  [[nodiscard]] std::uint64_t take_lost_results() noexcept {
    const std::uint64_t before = std::exchange(told_results_, lost_results());
    return told_results_ - before;
  }
  // Share of the ring in use, 0 … 1. Bound to the recorder's thread.
  [[nodiscard]] double fill() const;
  // Since the start.
  [[nodiscard]] std::uint64_t lost_records() const noexcept { return lost_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t lost_results() const noexcept { return lost_results_.load(std::memory_order_relaxed); }

 private:
  void push(RingResult result) noexcept;
  void hand_results(const Reader& reader);

  const std::size_t capacity_;
  boost::lockfree::spsc_queue<Record> records_;
  boost::lockfree::spsc_queue<RingResult, boost::lockfree::capacity<kResults>> results_;
  std::atomic<std::uint64_t> lost_{0}, lost_results_{0};
  std::uint64_t pending_gap_ = 0;   // the estimation thread: dropped records whose gap is not sent yet
  std::uint64_t pushed_ = 0;        // the estimation thread: records in the ring so far, gaps among them
  std::uint64_t popped_ = 0;        // the recorder's thread
  std::uint64_t told_results_ = 0;  // the recorder's thread: lost results that take_lost_results() has returned
  std::vector<Record> batch_;       // the recorder's thread
};

}  // namespace dwell::record
