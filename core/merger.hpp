// Merges the sources (one per device, plus ticks and actions) into one totally ordered stream.
//
// Order: (t_ns, source, arrival). A record is released once no live source can still deliver an earlier one: up to the
// watermark, the smallest newest instant over the live sources, but at most `hold_back` behind the newest of all. What
// comes later than what was already released is late: dropped and counted. Pure: no clock, no threads; memory is fixed
// at construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/record.hpp"

namespace dwell {

class Merger {
 public:
  enum class Admission : std::uint8_t { queued, late, full };

  // sources: number of sources, 1 …; hold_back_ns > 0; capacity: records held at most.
  Merger(std::size_t sources, std::int64_t hold_back_ns, std::size_t capacity);

  // Hands in one record of `source`. late: earlier than what has been released; full: no room (the caller counts the
  // drop either way). O(log capacity), no allocation.
  Admission push(std::size_t source, const Record& record) noexcept;

  // A source that is not live (its device is down) is not waited for. It becomes live again with its next record.
  void set_live(std::size_t source, bool live) noexcept;

  // Moves the next releasable record to `out`; false: nothing may be released yet. O(log capacity).
  bool pop(Record& out) noexcept;
  // The same without a watermark, for the end of a run.
  bool flush(Record& out) noexcept;

  // Records held now.
  [[nodiscard]] std::size_t size() const noexcept { return heap_.size(); }

 private:
  struct Entry {
    Record record;
    std::uint32_t source;
    std::uint64_t arrival;
  };
  struct Later {
    bool operator()(const Entry& a, const Entry& b) const noexcept;
  };
  [[nodiscard]] std::int64_t watermark() const noexcept;
  bool take(Record& out) noexcept;

  struct Source {
    std::int64_t newest_ns;
    bool live = false;
  };
  std::vector<Source> sources_;
  std::vector<Entry> heap_;
  std::size_t capacity_;
  std::int64_t hold_back_ns_;
  std::int64_t newest_ns_;
  std::int64_t released_ns_;
  std::uint64_t arrivals_ = 0;
};

}  // namespace dwell
