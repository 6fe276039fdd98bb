// Merges the sources (one per device, plus ticks and actions) into one totally ordered stream.
//
// Order: (t_ns, source, arrival). The merger releases the records before the watermark. The watermark is the smallest
// newest instant over the live sources: none of them delivers an earlier record. But it is at most `hold_back` behind
// the newest of all. A record older than the newest one released is late: it is dropped and counted. If the caller sets
// the time, stamps ahead of it do not shorten the wait for other sources. Pure: no clock, no threads; memory is fixed
// at construction.
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

  // sources: their number, 1 …; hold_back_ns > 0; capacity: records held at most of each source.
  Merger(std::size_t sources, std::int64_t hold_back_ns, std::size_t capacity);

  // Hands in one record of `source`. late: older than the newest record released; full: no room. In both cases the
  // caller counts the drop. O(1) in the order of instants, else one step per record overtaken. No allocation.
  Admission push(std::size_t source, const Record& record) noexcept;

  // The merger does not wait for a source that is not live (its device is down). The next record makes it live again.
  void set_live(std::size_t source, bool live) noexcept;

  // It is now_ns. Later stamps count as now_ns in the newest instant of all. Without a call no stamp is limited.
  void set_now(std::int64_t now_ns) noexcept { now_ns_ = now_ns; }
  // The stamps of this source may run ahead of the time (a recording played fast): set_now() does not limit them.
  void set_leading(std::size_t source) noexcept { sources_[source].leading = true; }

  // Moves the next releasable record to `out`; false: none may be released yet. O(sources).
  bool pop(Record& out) noexcept;
  // As pop(), without waiting for the watermark: for the end of a run.
  bool flush(Record& out) noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return held_; }

 private:
  // A ring of records in the order of their instants, and at equal instants in the order of arrival.
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
