#include "core/stream/merger.hpp"

#include <algorithm>
#include <cassert>
#include <limits>

namespace dwell {

Merger::Merger(std::size_t sources, std::int64_t hold_back_ns, std::size_t capacity)
    : sources_(sources, Source{std::vector<Record>(capacity), 0, 0, INT64_MIN}),
      hold_back_ns_(hold_back_ns),
      newest_ns_(INT64_MIN),
      released_ns_(INT64_MIN) {
  assert(sources > 0 && hold_back_ns > 0 && capacity > 0);
}

Merger::Admission Merger::push(std::size_t source, const Record& record) noexcept {
  assert(source < sources_.size());
  Source& from = sources_[source];
  from.live = true;
  if (record.t_ns < released_ns_) return Admission::late;
  if (from.count == from.ring.size()) return Admission::full;
  std::size_t place = from.count++;
  for (; place > 0 && from.at(place - 1).t_ns > record.t_ns; --place) from.at(place) = from.at(place - 1);
  from.at(place) = record;
  ++held_;
  from.newest_ns = std::max(from.newest_ns, record.t_ns);
  newest_ns_ = std::max(newest_ns_, from.leading ? record.t_ns : std::min(record.t_ns, now_ns_));
  return Admission::queued;
}

void Merger::set_live(std::size_t source, bool live) noexcept { sources_[source].live = live; }

bool Merger::take_before(std::int64_t limit_ns, Record& out) noexcept {
  Source* next = nullptr;
  std::int64_t earliest_ns = limit_ns;
  for (Source& source : sources_) {
    if (source.count == 0 || source.at(0).t_ns >= earliest_ns) continue;  // of equal instants the first source's
    next = &source;
    earliest_ns = source.at(0).t_ns;
  }
  if (next == nullptr) return false;
  out = next->at(0);
  next->first = next->first + 1 < next->ring.size() ? next->first + 1 : 0;
  --next->count;
  --held_;
  released_ns_ = out.t_ns;
  return true;
}

bool Merger::pop(Record& out) noexcept {
  if (held_ == 0) return false;
  std::int64_t slowest_ns = newest_ns_;
  for (const Source& source : sources_)
    if (source.live) slowest_ns = std::min(slowest_ns, source.newest_ns);
  // Records at the watermark wait: a source may still deliver one of the same instant.
  return take_before(std::max(slowest_ns, newest_ns_ - hold_back_ns_), out);
}

bool Merger::flush(Record& out) noexcept { return take_before(std::numeric_limits<std::int64_t>::max(), out); }

}  // namespace dwell
