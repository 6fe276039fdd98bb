#include "daemon/ctl/child_events.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_line.hpp"

namespace dwell::ctl {
namespace {

constexpr std::int64_t kTogether_ns = 1'000'000'000;  // a fault that repeats makes one event in so long, as in a run

}  // namespace

std::optional<record::StoredEvent> StateEvents::follow(const Replay& replay) {
  if (!replay.state_changed()) return std::nullopt;
  const std::optional<Dwell> dwell = replay.current();
  if (!dwell || dwell->state == state_) return std::nullopt;
  record::StoredEvent event;
  event.position = replay.position();
  event.what = "state";
  event.text = state_line(std::exchange(state_, dwell->state), *dwell);
  return event;
}

ChildEvents::ChildEvents(const record::RunHeader& parent, std::int64_t begin_ns, const Rig& rig,
                         std::vector<std::string> devices)
    : start_utc_ns_(record::parse_utc(parent.start_utc).value_or(0)),
      begin_ns_(begin_ns),
      newest_ns_(begin_ns),
      drain_ns_(begin_ns + kTogether_ns),
      names_{{}, std::move(devices)} {
  for (const Channel& channel : rig.channels) names_.channels.push_back(channel.name);
}

std::vector<record::StoredEvent> ChildEvents::follow(const Record& record, const Replay& replay) {
  std::vector<record::StoredEvent> events;
  newest_ns_ = record.t_ns;
  // A pipeline is born with the states that hold, and a run reaches back to that: its own file does not tell those
  // before it began.
  if (is_edge(record, RunEdge::begins)) run_began_ = true;
  if (record.kind != Kind::channel_state || run_began_) stream_.take(record, replay.position());
  if (record.t_ns >= drain_ns_) drain(events);
  if (auto change = states_.follow(replay)) {
    change->utc = utc_of(record.t_ns);
    events.push_back(std::move(*change));
  }
  return events;
}

std::vector<record::StoredEvent> ChildEvents::finish() {
  std::vector<record::StoredEvent> events;
  drain(events);
  return events;
}

void ChildEvents::drain(std::vector<record::StoredEvent>& into) {
  drain_ns_ = newest_ns_ + kTogether_ns;
  std::vector<record::StoredEvent> told = stream_.drain(names_, [this](std::int64_t t_ns) { return utc_of(t_ns); });
  std::move(told.begin(), told.end(), std::back_inserter(into));
}

std::string ChildEvents::utc_of(std::int64_t t_ns) const { return record::iso_utc(start_utc_ns_ + (t_ns - begin_ns_)); }

}  // namespace dwell::ctl
