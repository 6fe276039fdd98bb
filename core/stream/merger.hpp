// Merges the sources (one per device, plus ticks and actions) into one totally ordered stream.
//
// Order: (t_ns, source, arrival). A record is released once no live source can still deliver an earlier one: up to the
// watermark, the smallest newest instant over the live sources, but at most `hold_back` behind the newest of all. What
// comes later than what was already released is late: dropped and counted. Where the caller says what time it is, no
// stamp ahead of that shortens the wait for the others. Pure: no clock, no threads; memory is fixed at construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/stream/record.hpp"

namespace dwell {

class Merger {
 public:
  enum class Admission : std::uint8_t { queued, late, full };

  // sources: number of sources, 1 …; hold_back_ns > 0; capacity: records held at most of each source.
  Merger(std::size_t sources, std::int64_t hold_back_ns, std::size_t capacity);

  // Hands in one record of `source`. late: earlier than what has been released; full: no room (the caller counts the
  // drop either way). O(1) in the order of instants, else one step per record it overtakes. No allocation.
  Admission push(std::size_t source, const Record& record) noexcept;

  // A source that is not live (its device is down) is not waited for. It becomes live again with its next record.
  void set_live(std::size_t source, bool live) noexcept;

  // It is now_ns: instants beyond count as now_ns for the newest of all. Without a call every stamp counts as it is.
  void set_now(std::int64_t now_ns) noexcept { now_ns_ = now_ns; }
  // The stamps of this source may run ahead of the time (a recording played fast): they count as they are.
  void set_leading(std::size_t source) noexcept { sources_[source].leading = true; }

  // Moves the next releasable record to `out`; false: nothing may be released yet. O(sources).
  bool pop(Record& out) noexcept;
  // The same without a watermark, for the end of a run.
  bool flush(Record& out) noexcept;

  // Records held now.
  [[nodiscard]] std::size_t size() const noexcept { return held_; }

 private:
  // A ring of records in the order of their instants; equal instants in the order of arrival.
  struct Source {
    std::vector<Record> ring;
    std::size_t first = 0, count = 0;
    std::int64_t newest_ns;
    bool live = false;
    bool leading = false;
    [[nodiscard]] Record& at(std::size_t i) noexcept {
      return ring[first + i < ring.size() ? first + i : first + i - ring.size()];
    }
  };
  bool take_before(std::int64_t limit_ns, Record& out) noexcept;

  std::vector<Source> sources_;
  std::size_t held_ = 0;
  std::int64_t hold_back_ns_;
  std::int64_t newest_ns_;
  std::int64_t released_ns_;
  std::int64_t now_ns_ = std::numeric_limits<std::int64_t>::max();
};

}  // namespace dwell
