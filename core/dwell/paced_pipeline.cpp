#include "core/dwell/paced_pipeline.hpp"

#include <algorithm>

namespace dwell {
namespace {

// Records that wait at most: 2 s of 64 channels at 1 kHz, twice what the longest work holds up there. Where there are
// more, the next push waits for the work.
constexpr std::size_t kMostWaiting = std::size_t{1} << 17;
// Of records that wait, so many are taken at a push: the backlog shrinks as fast as it grew.
constexpr int kTogether = 2;

}  // namespace

PacedPipeline::PacedPipeline(const Rig& rig)
    : slices_([this] { take(ring_[first_]); }), pipeline_(rig, &slices_), taken_(rig.channels.size()) {
  ring_.resize(kMostWaiting);
}

// What is in work is done first: it needs the pipeline.
PacedPipeline::~PacedPipeline() {
  slices_.allow_all();
  if (busy()) slices_.go_on();
}

std::uint8_t PacedPipeline::push(const Record& record) noexcept {
  if (newest_ns_ != INT64_MIN)
    slices_.allow(kPerSecond * 1e-9 * static_cast<double>(record.t_ns - newest_ns_), kAtOnce);
  newest_ns_ = std::max(newest_ns_, record.t_ns);
  changes_ = kNothing;
  if (count_ == 0 && !pipeline_.may_take_long(record)) {
    take(record);
    return changes_;
  }
  if (count_ == ring_.size()) make_room();
  ring_[(first_ + count_) % ring_.size()] = record;
  ++count_;
  for (int i = 0; i < kTogether && count_ > 0 && changes_ == kNothing && slices_.may_work(); ++i)
    if (!take_next()) break;
  return changes_;
}

std::uint8_t PacedPipeline::flush() noexcept {
  slices_.allow_all();
  changes_ = kNothing;
  while (count_ > 0 && changes_ == kNothing) take_next();
  return changes_;
}

void PacedPipeline::make_room() noexcept {
  slices_.allow_all();
  take_next();
  slices_.allow(0.0, kAtOnce);
}

// The oldest that waits; false: it has gone away amid its work.
bool PacedPipeline::take_next() noexcept {
  if (!(busy() ? slices_.go_on() : slices_.begin())) return false;
  first_ = (first_ + 1) % ring_.size();
  --count_;
  return true;
}

void PacedPipeline::take(const Record& record) noexcept {
  if (record.kind == Kind::sample) ++taken_[record.channel];
  changes_ = pipeline_.push(record);
}

}  // namespace dwell
