// The events that wait for one reader of a live stream. Bounded: where the reader is slow, events are dropped. A reader
// that lost an event is right again with the next whole dwell, within a second; it asks for lost traces. Some events
// yield to the others, as traces do to dwells: they wait behind these and are dropped before them. Bound to one thread.
#pragma once

#include <cstddef>
#include <deque>
#include <memory>
#include <string>

namespace dwell {

class EventQueue {
 public:
  using Event = std::shared_ptr<const std::string>;

  // most: events that wait, at least 1.
  explicit EventQueue(std::size_t most) : most_(most) {}

  // False: there was no room, and one event was dropped: the oldest that yields, else the oldest. A yielding event that
  // finds none of its own kind to replace is dropped itself.
  bool push(Event event, bool yields) {
    const bool room = first_.size() + yielding_.size() < most_;
    if (!room && yields && yielding_.empty()) return false;
    if (!room) (yielding_.empty() ? first_ : yielding_).pop_front();
    (yields ? yielding_ : first_).push_back(std::move(event));
    return room;
  }
  // Takes the next one out: the oldest that does not yield, else the oldest; null: none waits.
  Event take() {
    std::deque<Event>& from = first_.empty() ? yielding_ : first_;
    if (from.empty()) return nullptr;
    Event event = std::move(from.front());
    from.pop_front();
    return event;
  }
  void clear() noexcept {
    first_.clear();
    yielding_.clear();
  }

 private:
  std::size_t most_;
  std::deque<Event> first_, yielding_;  // oldest first
};

}  // namespace dwell
