#include "core/merger.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace dwell {
namespace {
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::min();
}

bool Merger::Later::operator()(const Entry& a, const Entry& b) const noexcept {
  if (a.record.t_ns != b.record.t_ns) return a.record.t_ns > b.record.t_ns;
  if (a.source != b.source) return a.source > b.source;
  return a.arrival > b.arrival;
}

Merger::Merger(std::size_t sources, std::int64_t hold_back_ns, std::size_t capacity)
    : sources_(sources, Source{kNever, false}),
      capacity_(capacity),
      hold_back_ns_(hold_back_ns),
      newest_ns_(kNever),
      released_ns_(kNever) {
  assert(sources > 0 && hold_back_ns > 0);
  heap_.reserve(capacity);
}

Merger::Admission Merger::push(std::size_t source, const Record& record) noexcept {
  assert(source < sources_.size());
  if (record.t_ns < released_ns_) return Admission::late;
  if (heap_.size() == capacity_) return Admission::full;
  heap_.push_back({record, static_cast<std::uint32_t>(source), arrivals_++});
  std::push_heap(heap_.begin(), heap_.end(), Later{});
  Source& from = sources_[source];
  from.live = true;
  from.newest_ns = std::max(from.newest_ns, record.t_ns);
  newest_ns_ = std::max(newest_ns_, record.t_ns);
  return Admission::queued;
}

void Merger::set_live(std::size_t source, bool live) noexcept { sources_[source].live = live; }

std::int64_t Merger::watermark() const noexcept {
  if (newest_ns_ == kNever) return kNever;
  std::int64_t slowest = newest_ns_;
  for (const Source& source : sources_)
    if (source.live) slowest = std::min(slowest, source.newest_ns);
  return std::max(slowest, newest_ns_ - hold_back_ns_);
}

bool Merger::take(Record& out) noexcept {
  std::pop_heap(heap_.begin(), heap_.end(), Later{});
  out = heap_.back().record;
  heap_.pop_back();
  released_ns_ = out.t_ns;
  return true;
}

bool Merger::pop(Record& out) noexcept {
  // Equal instants wait as well: a source at the watermark may still deliver a record of this very instant.
  if (heap_.empty() || heap_.front().record.t_ns >= watermark()) return false;
  return take(out);
}

bool Merger::flush(Record& out) noexcept { return !heap_.empty() && take(out); }

}  // namespace dwell
