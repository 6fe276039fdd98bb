// What comes before the run or the record that it belongs to.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>
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

// Labels for runs whose records the recorder has not read yet. Bound to one thread.
class AwaitedLabels {
 public:
  static constexpr std::size_t kMost = 64;  // as AwaitedRequests::kMost
  // How long a label waits for its run. The recorder reads the stream some tens of ms later, or as much later as the
  // disk is slow. Doubled, an operator hears later that the label is lost.
  static constexpr std::int64_t kPatience_ns = 5'000'000'000;

  void add(Request request, std::int64_t now_ns) { labels_.push_back({std::move(request), now_ns}); }
  // The record of this request has come.
  void saw(std::uint16_t number) noexcept { newest_ = number; }
  // The next label whose request before it has come; nullopt: there is none.
  [[nodiscard]] std::optional<Request> next() {
    if (labels_.empty() || !is_due(labels_.front().request)) return std::nullopt;
    return take();
  }
  // The next one that has waited for too long, or is one too many.
  [[nodiscard]] std::optional<Request> next_lost(std::int64_t now_ns) {
    const bool late = !labels_.empty() && now_ns - labels_.front().since_ns >= kPatience_ns;
    return late || labels_.size() > kMost ? take() : std::nullopt;
  }

 private:
  struct Awaited {
    Request request;
    std::int64_t since_ns;
  };
  // Numbers begin anew after 65535. So of any two, the one that is less than half of them ahead is the newer one.
  [[nodiscard]] bool is_due(const Request& request) const noexcept {
    return request.after == 0 || static_cast<std::uint16_t>(newest_ - request.after) < 0x8000;
  }
  std::optional<Request> take() {
    Request request = std::move(labels_.front().request);
    labels_.pop_front();
    return request;
  }

  std::deque<Awaited> labels_;
  std::uint16_t newest_ = 0;
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
