// What comes before the run or the record that it belongs to.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <utility>
#include <vector>

#include "core/stream/record.hpp"
#include "daemon/record/request.hpp"
#include "daemon/record/run_entries.hpp"
#include "daemon/record/run_store.hpp"

namespace dwell::record {

// Operators' requests whose records have not come yet. Bound to one thread.
class AwaitedRequests {
 public:
  static constexpr std::size_t kMost = 64;

  void add(Request request) {
    if (requests_.size() == kMost) requests_.pop_front();
    requests_.push_back(std::move(request));
  }
  // Null: no operator asked for this record.
  [[nodiscard]] const Request* of(const Record& record) const noexcept {
    if (record.channel == 0 || (record.kind != Kind::run && record.kind != Kind::action)) return nullptr;
    const auto newest = std::find_if(requests_.rbegin(), requests_.rend(),
                                     [&](const Request& request) { return request.number == record.channel; });
    return newest == requests_.rend() ? nullptr : &*newest;
  }

 private:
  std::deque<Request> requests_;  // newest last
};

// Events while no run goes on: a run that reaches back to them begins with them. Bound to one thread.
class EarlyEvents {
 public:
  static constexpr std::size_t kMost = 64;

  // number: of the record before it.
  void add(std::uint64_t number, StoredEvent event) {
    if (events_.size() == kMost) events_.pop_front();
    events_.emplace_back(number, std::move(event));
  }
  // Hands over those from record `born` on, as entries that cover the time up to t_ns, and keeps none.
  [[nodiscard]] std::vector<NewEntry> take_from(std::uint64_t born, std::int64_t t_ns) {
    std::vector<NewEntry> entries;
    for (auto& [number, event] : events_) {
      if (number < born) continue;
      event.position = number + 1 - born;
      entries.push_back({"event", t_ns, to_json(event)});
    }
    events_.clear();
    return entries;
  }
  void clear() noexcept { events_.clear(); }

 private:
  std::deque<std::pair<std::uint64_t, StoredEvent>> events_;
};

}  // namespace dwell::record
