#include "daemon/record/record_ring.hpp"

#include <algorithm>
#include <utility>

namespace dwell::record {
namespace {

constexpr double kSeconds = 6.0;
constexpr std::size_t kFloor = 1u << 16;
constexpr std::size_t kCeiling = 1u << 23;
constexpr std::size_t kBatch = 4096;  // records handed over in one go: 128 KiB

// A gap is sent as a record of Kind::run without a RunEdge, which no stream contains.
constexpr std::uint8_t kGapMark = 0;
bool is_gap(const Record& record) { return record.kind == Kind::run && record.flags == kGapMark; }

}  // namespace

std::size_t ring_records(double rate_hz) noexcept {
  // Beside the samples there are states, edges and a hundred ticks a second: a thousand is ample.
  const double records = kSeconds * (std::max(rate_hz, 0.0) + 1000.0);
  if (!(records < static_cast<double>(kCeiling))) return kCeiling;
  return std::max(kFloor, static_cast<std::size_t>(records));
}

RecordRing::RecordRing(std::size_t records) : capacity_(records), records_(records), batch_(kBatch) {}

RecordRing::~RecordRing() {
  for (RingResult left; results_.pop(left);) {  // the queue does not destroy what is left in it
  }
}

void RecordRing::push(const Record& record) noexcept {
  if (pending_gap_ > 0) {
    const Record gap{
        .t_ns = record.t_ns, .value = static_cast<double>(pending_gap_), .kind = Kind::run, .flags = kGapMark};
    if (records_.write_available() > capacity_ / 2 && records_.push(gap)) {
      pending_gap_ = 0;
      ++pushed_;
    }
  }
  if (pending_gap_ == 0 && records_.push(record)) {
    ++pushed_;
    return;
  }
  ++pending_gap_;
  lost_.fetch_add(1, std::memory_order_relaxed);
}

void RecordRing::push(std::uint64_t position, bool final, std::shared_ptr<const Dwell> dwell) noexcept {
  push(RingResult{position, final, std::move(dwell), {}, {}, pushed_});
}

void RecordRing::push(std::uint64_t position, ModelResult model) noexcept {
  push(RingResult{position, false, nullptr, std::move(model), {}, pushed_});
}

void RecordRing::push(const StateChange& change, std::shared_ptr<const Dwell> after) noexcept {
  push(RingResult{0, false, std::move(after), {}, change, pushed_});
}

void RecordRing::push(RingResult result) noexcept {
  // A result that was published in a gap has no position in the stream, so it is lost too.
  if (pending_gap_ == 0 && results_.push(std::move(result))) return;
  lost_results_.fetch_add(1, std::memory_order_relaxed);
}

// If a record is visible here, so is every result that was pushed before it. So no result is missed.
void RecordRing::hand_results(const Reader& reader) {
  while (results_.read_available() > 0 && results_.front().after <= popped_) {
    RingResult result;
    results_.pop(result);
    reader.result(result);
  }
}

void RecordRing::drain(const Reader& reader) {
  // At most as many records as the ring holds: a producer that keeps pace must not keep this thread here.
  for (std::size_t turns = 1 + capacity_ / kBatch; turns > 0; --turns) {
    const std::size_t count = records_.pop(batch_.data(), batch_.size());
    for (std::size_t i = 0; i < count; ++i) {
      hand_results(reader);
      const Record& record = batch_[i];
      ++popped_;
      if (is_gap(record)) {
        reader.gap(static_cast<std::uint64_t>(record.value));
      } else {
        reader.record(record);
      }
    }
    if (count == 0) break;
  }
  hand_results(reader);
}

double RecordRing::fill() const {
  return static_cast<double>(records_.read_available()) / static_cast<double>(capacity_);
}

}  // namespace dwell::record
