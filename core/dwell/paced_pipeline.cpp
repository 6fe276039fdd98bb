#include "core/dwell/paced_pipeline.hpp"

#include <algorithm>
#include <cassert>

#include "core/dwell/history_capacity.hpp"

namespace dwell {
namespace {

// Waiting records taken in one push: the backlog shrinks as fast as it grew.
constexpr int kTogether = 2;
// Stream time for which a push may work at most; a stream that jumps earns no more.
constexpr double kLongestEarned_s = 1.0;

bool must_not_wait(const Record& record) noexcept {
  return record.kind == Kind::action ||
         (record.kind == Kind::edge && record.channel == static_cast<std::uint16_t>(Line::interlock));
}

}  // namespace

// The ring: work on the longest hold is four passes over its samples, a second of the stream. No more records can come
// meanwhile. If more come, a push waits for the work.
PacedPipeline::PacedPipeline(const Rig& rig)
    : slices_([this] { take(ring_[first_]); }),
      pipeline_(rig, &slices_),
      taken_(rig.channels.size()),
      ring_(history_capacity(static_cast<int>(rig.channels.size()))) {}

// Unfinished work needs the pipeline: it is done first.
PacedPipeline::~PacedPipeline() {
  slices_.allow_all();
  if (busy()) slices_.go_on();
}

std::uint8_t PacedPipeline::push(const Record& record) noexcept {
  earn(record.t_ns);
  changes_ = kNothing;
  if (count_ == 0 && !pipeline_.may_take_long(record)) {
    take(record);
    return changes_;
  }
  append(record);
  for (int i = 0; count_ > 0 && changes_ == kNothing && (urgent_ > 0 || (i < kTogether && slices_.may_work())); ++i) {
    if (urgent_ > 0) slices_.allow_all();
    if (!take_next()) break;
    if (urgent_ == 0) slices_.allow(0.0, kAtOnce);
  }
  return changes_;
}

// push() earns work before it takes a record, this afterwards. The result is the same: taking in a sample spends none.
std::size_t PacedPipeline::push_in_block(std::span<const Record> records) noexcept {
  if (count_ > 0) return 0;
  changes_ = kNothing;
  const std::size_t n = pipeline_.push_in_block(records);
  std::uint64_t* const taken = taken_.data();
  const std::size_t channels = taken_.size();
  for (const Record& record : records.first(n)) {
    if (record.t_ns != newest_ns_) earn(record.t_ns);
    if (record.kind == Kind::sample && record.channel < channels) ++taken[record.channel];
  }
  return n;
}

std::uint8_t PacedPipeline::flush() noexcept {
  slices_.allow_all();
  changes_ = kNothing;
  while (count_ > 0 && changes_ == kNothing) take_next();
  return changes_;
}

std::uint8_t PacedPipeline::finish() {
  assert(count_ == 0);
  return pipeline_.finish();
}

// A record without an instant, or out of order, earns nothing: the pipeline will refuse it.
void PacedPipeline::earn(std::int64_t t_ns) noexcept {
  if (t_ns <= newest_ns_ || t_ns > Pipeline::kLatest_ns) return;
  const double since_s = 1e-9 * (static_cast<double>(t_ns) - static_cast<double>(newest_ns_));
  slices_.allow(kPerSecond * std::min(since_s, kLongestEarned_s), kAtOnce);
  newest_ns_ = t_ns;
}

void PacedPipeline::append(const Record& record) noexcept {
  if (count_ == ring_.size()) {
    slices_.allow_all();
    take_next();
    slices_.allow(0.0, kAtOnce);
  }
  ring_[(first_ + count_) % ring_.size()] = record;
  ++count_;
  if (must_not_wait(record)) urgent_ = count_;
}

// Takes the oldest record that waits; false: its work has paused.
bool PacedPipeline::take_next() noexcept {
  if (!(busy() ? slices_.go_on() : slices_.begin())) return false;
  first_ = (first_ + 1) % ring_.size();
  --count_;
  urgent_ -= urgent_ > 0 ? 1 : 0;
  return true;
}

void PacedPipeline::take(const Record& record) noexcept {
  count(record);
  changes_ = pipeline_.push(record);
}

}  // namespace dwell
