#include "daemon/estimate/estimator.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "daemon/estimate/dwell_line.hpp"

namespace dwell {
namespace {

constexpr std::size_t kScratch = 1024;
constexpr std::size_t kActions = 16;
// A stamp further ahead of the clock is a mistake of its device. Far above any stall between the clock being read and
// the rings being emptied: halved, a stall may cost good samples; doubled, a wrong stamp waits longer to be used.
constexpr std::int64_t kAhead_ns = 1'000'000'000;
// Nothing of a channel could be put in order for so long: it does not deliver.
constexpr std::int64_t kUntimely_ns = 1'000'000'000;
// The driver interface asks for a turn every 0.5 s; six times that is no stall.
constexpr std::int64_t kHung_ns = 3'000'000'000;
constexpr std::size_t kSpare = 4096;  // room in the merger for ticks, actions and states beside the samples

// Of each source.
std::size_t merger_capacity(const std::vector<DeviceLink*>& links) {
  std::size_t largest = 0;
  for (const DeviceLink* link : links)
    if (link != nullptr) largest = std::max(largest, link->capacity());
  return kSpare + 2 * largest;
}

// A device without a link is not heard.
std::vector<Assembler::Source> sources_of(const Rig& rig, const std::vector<DeviceLink*>& links,
                                          const std::vector<bool>& leads) {
  std::vector<Assembler::Source> sources = Assembler::sources(rig);
  for (std::size_t i = 0; i < links.size(); ++i) {
    sources[i].channels = links[i] != nullptr ? links[i]->channels() : std::vector<std::uint16_t>{};
    sources[i].leads = i < leads.size() && leads[i];
  }
  return sources;
}

std::string seconds(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", static_cast<double>(ns) * 1e-9);
  return text;
}

std::string milliseconds(std::int64_t ns) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0f ms", static_cast<double>(ns) * 1e-6);
  return text;
}

ClockView clock_view(const Device& device, const ClockFigures& figures) {
  constexpr double kOtherRate_ppm = 1e5;  // what is further off has nothing to do with the rate stated
  ClockView view;
  view.kind = device.clock;
  view.rate_hz = figures.rate_hz;
  view.jitter_s = figures.jitter_s;
  view.lost = figures.lost;
  const double drift_ppm = 1e6 * (figures.rate_hz / device.rate_hz - 1.0);
  if (device.rate_hz > 0.0 && std::abs(drift_ppm) < kOtherRate_ppm) view.drift_ppm = drift_ppm;
  return view;
}

}  // namespace

Estimator::Estimator(const Rig& rig, std::vector<DeviceLink*> links, const EstimatorOptions& options, Log& log,
                     std::function<void()> published, std::int64_t now_ns)
    : rig_(rig),
      links_(std::move(links)),
      options_(options),
      log_(log),
      published_(std::move(published)),
      assembler_(sources_of(rig, links_, options.leads), options.hold_back_ns, merger_capacity(links_)),
      pipeline_(rig),
      watch_(options.nominal_rate_hz, now_ns),
      actions_(kActions),
      scratch_(kScratch),
      channels_(rig.channels.size()),
      devices_(links_.size()),
      next_publish_ns_(now_ns),
      finished_(options.kept_dwells, options.kept_bytes) {
  for (std::size_t i = 0; i < links_.size(); ++i) {
    if (links_[i] == nullptr) continue;
    const auto& channels = links_[i]->channels();
    const bool known = !channels.empty() && channels.front() < options_.nominal_rate_hz.size();
    const double rate_hz = known ? options_.nominal_rate_hz[channels.front()] : 0.0;
    devices_[i].lines.emplace(links_[i]->name(), rate_hz, log_);
  }
}

Estimator::~Estimator() = default;

void Estimator::turn(std::int64_t now_ns, std::int64_t utc_ns, std::uint64_t skipped) {
  if (start_utc_ns_ == 0) start_utc_ns_ = utc_ns;
  skipped_ += skipped;
  assembler_.set_now(now_ns);
  offer_states();
  for (std::size_t device = 0; device < links_.size(); ++device) {
    if (links_[device] == nullptr) continue;
    take_events(device, now_ns);
    take_samples(device, now_ns);
    tell_recoveries(device, now_ns);
  }
  find_hung(now_ns);
  find_silence(now_ns);
  find_untimely(now_ns);
  take_edges(now_ns);
  // Actions and the tick last: a backlog in the rings must not look late beside them.
  Action action{};
  while (actions_.pop(action)) {
    Record record;
    record.t_ns = now_ns;
    record.kind = Kind::action;
    record.flags = static_cast<std::uint8_t>(action);
    assembler_.action(record);
  }
  assembler_.tick(now_ns);
  release(false);
  settle_counters();
  if (now_ns >= next_publish_ns_) {
    const auto period_ns = static_cast<std::int64_t>(rig_.update_s * 1e9);
    next_publish_ns_ = std::max(next_publish_ns_ + period_ns, now_ns);
    tell_counted_faults(now_ns);
    publish(now_ns);
  }
}

void Estimator::finish(std::int64_t now_ns, std::int64_t utc_ns) {
  turn(now_ns, utc_ns);
  for (std::size_t device = 0; device < links_.size(); ++device) {
    if (links_[device] == nullptr) continue;
    assembler_.stopped(
        device, [this](Record& r) { enters(r); },
        [&](const Record& r, Merger::Admission a) { admitted(device, r, a, now_ns); });
  }
  release(true);
  offer_states();
  release(true);
  note(pipeline_.finish());
  settle_counters();
  publish(now_ns);
  for (std::size_t device = 0; device < links_.size(); ++device)
    if (links_[device] != nullptr) devices_[device].lines->end(occurrences(device, Fault::missed_deadline));
}

void Estimator::take_events(std::size_t device, std::int64_t now_ns) {
  DeviceLink& link = *links_[device];
  StateEvent event;
  while (link.pop_event(event)) {
    for (const std::uint16_t channel : link.channels()) {
      if (event.channel >= 0 && event.channel != channel) continue;
      const std::int64_t stale_ns = event.t_ns - watch_[channel].since_ns;
      if (!watch_.said(channel, event.t_ns, event.fault, event.reason.data())) continue;
      admit_state(device, channel, event.t_ns, event.fault);
      PerChannel& own = channels_[channel];
      own.recovered = event.fault == Fault::none;
      own.stale = !own.recovered;
      if (own.recovered) own.stale_ns = stale_ns;
    }
  }
  tell_stale(device, now_ns);
}

void Estimator::take_samples(std::size_t device, std::int64_t now_ns) {
  DeviceLink& link = *links_[device];
  const auto enter = [this](Record& record) { enters(record); };
  const auto decided = [&](const Record& record, Merger::Admission admission) {
    admitted(device, record, admission, now_ns);
  };
  // A driver faster than this loop must not keep it from going on: one ring's worth at most.
  for (std::size_t left = link.capacity(); left > 0;) {
    const std::size_t taken = link.pop_samples(scratch_.data(), std::min(left, scratch_.size()));
    if (taken == 0) break;
    left -= taken;
    for (std::size_t i = 0; i < taken; ++i) {
      const Record& record = scratch_[i];
      if (stamped_ahead(device, record, now_ns)) continue;
      heard(device, record, now_ns);
      assembler_.sample(device, record, enter, decided);
    }
  }
  assembler_.wait(device, now_ns, enter, decided);
  const bool live = std::any_of(link.channels().begin(), link.channels().end(),
                                [this](std::uint16_t channel) { return watch_[channel].fault == Fault::none; });
  if (!live) assembler_.stopped(device, enter, decided);
}

// A sample is proof that its channel delivers. One that delivers what cannot be put in order is not back before one
// can.
void Estimator::heard(std::size_t device, const Record& record, std::int64_t now_ns) {
  if (watch_[record.channel].fault == Fault::untimely) {
    watch_.heard(record.channel, now_ns);
    return;
  }
  const std::int64_t stale_ns = record.t_ns - watch_[record.channel].since_ns;
  if (!watch_.sample(record.channel, record.t_ns, now_ns)) return;
  PerChannel& own = channels_[record.channel];
  own.recovered = true;
  own.stale_ns = stale_ns;
  admit_state(device, record.channel, record.t_ns, Fault::none);
}

// Dropped before it reaches clocks and merger: at its stamp it would be a wrong reading, whenever that comes.
bool Estimator::stamped_ahead(std::size_t device, const Record& record, std::int64_t now_ns) {
  const bool leads = device < options_.leads.size() && options_.leads[device];
  if (leads || record.t_ns - now_ns <= kAhead_ns) return false;
  DeviceLink& link = *links_[device];
  link.counters(link.position(record.channel)).ahead();
  watch_.heard(record.channel, now_ns);
  note_untimely(record.channel, record.t_ns, now_ns);
  return true;
}

void Estimator::note_untimely(std::size_t channel, std::int64_t t_ns, std::int64_t now_ns) {
  PerChannel& own = channels_[channel];
  own.gap = 1;
  own.untimely_by_ns = now_ns - t_ns;
  if (own.untimely_since_ns == 0) own.untimely_since_ns = now_ns;
}

// Called for each sample just before it enters the merger.
void Estimator::enters(Record& record) {
  PerChannel& own = channels_[record.channel];
  own.half_width_s = record.t_half_ns * 1e-9;
  if (own.gap != 0) record.flags |= kGap;
}

void Estimator::admitted(std::size_t device, const Record& record, Merger::Admission admission, std::int64_t now_ns) {
  DeviceLink& link = *links_[device];
  PerChannel& own = channels_[record.channel];
  ChannelCounters& counters = link.counters(link.position(record.channel));
  switch (admission) {
    case Merger::Admission::queued:
      own.gap = 0;
      own.untimely_since_ns = 0;
      if (watch_[record.channel].fault == Fault::untimely) {
        own.recovered = true;
        own.stale_ns = now_ns - watch_[record.channel].since_ns;
        watch_.said(record.channel, now_ns, Fault::none, nullptr);
      }
      break;
    case Merger::Admission::late:
      counters.late();
      note_untimely(record.channel, record.t_ns, now_ns);
      break;
    case Merger::Admission::full:
      own.gap = 1;
      counters.overflow();
      break;
  }
}

void Estimator::admit_state(std::size_t device, std::size_t channel, std::int64_t t_ns, Fault fault) {
  Record record;
  record.t_ns = t_ns;
  record.channel = static_cast<std::uint16_t>(channel);
  record.kind = Kind::channel_state;
  record.flags = static_cast<std::uint8_t>(fault);
  // Only the newest counts: where there is no room it waits.
  std::optional<Record>& waiting = channels_[channel].state;
  waiting.reset();
  if (!assembler_.state(device, record)) waiting = record;
}

// What the merger had no room for; a state is never lost.
void Estimator::offer_states() {
  for (std::size_t channel = 0; channel < channels_.size(); ++channel) {
    std::optional<Record>& waiting = channels_[channel].state;
    if (!waiting) continue;
    if (assembler_.state(static_cast<std::size_t>(rig_.channels[channel].device), *waiting)) waiting.reset();
  }
}

// A driver that hangs in a call takes its own channels with it and nothing else.
void Estimator::find_hung(std::int64_t now_ns) {
  for (std::size_t device = 0; device < links_.size(); ++device) {
    if (links_[device] == nullptr) continue;
    const std::int64_t still_ns = now_ns - links_[device]->last_turn_ns();
    const auto& channels = links_[device]->channels();
    // A source that has been played to its end has nothing left to turn for.
    const bool ended = std::all_of(channels.begin(), channels.end(), [this](std::uint16_t channel) {
      return watch_[channel].fault == Fault::end_of_data;
    });
    if (still_ns <= kHung_ns || ended) {
      devices_[device].hangs = false;
      continue;
    }
    if (std::exchange(devices_[device].hangs, true)) continue;
    ++devices_[device].silences;
    const std::string reason = "its driver hangs: no turn of its thread for " + seconds(still_ns);
    for (const std::uint16_t channel : channels) {
      if (!watch_.said(channel, now_ns, Fault::silent, reason.c_str())) continue;
      admit_state(device, channel, now_ns, Fault::silent);
      channels_[channel].stale = true;
    }
    tell_stale(device, now_ns);
  }
}

void Estimator::find_untimely(std::int64_t now_ns) {
  for (std::size_t device = 0; device < links_.size(); ++device) {
    if (links_[device] == nullptr) continue;
    for (const std::uint16_t channel : links_[device]->channels()) {
      PerChannel& own = channels_[channel];
      const Fault fault = watch_[channel].fault;
      const bool coming = now_ns - watch_[channel].heard_ns < kUntimely_ns;
      if (own.untimely_since_ns == 0 || now_ns - own.untimely_since_ns < kUntimely_ns || !coming ||
          (fault != Fault::none && fault != Fault::silent))
        continue;
      const std::string reason =
          own.untimely_by_ns < 0
              ? "every reading is stamped ahead of the clock, the newest by " + seconds(-own.untimely_by_ns)
              : "every reading comes too late to be put in order: the newest " + milliseconds(own.untimely_by_ns) +
                    " after its stamp, and " + milliseconds(options_.hold_back_ns) + " are waited for";
      watch_.said(channel, now_ns, Fault::untimely, reason.c_str());
      admit_state(device, channel, now_ns, Fault::untimely);
      own.stale = true;
      ++devices_[device].untimely;
    }
    tell_stale(device, now_ns);
  }
}

void Estimator::find_silence(std::int64_t now_ns) {
  for (std::size_t device = 0; device < links_.size(); ++device) {
    if (links_[device] == nullptr) continue;
    for (const std::uint16_t channel : links_[device]->channels()) {
      if (!watch_.fell_silent(channel, now_ns)) continue;
      admit_state(device, channel, now_ns, Fault::silent);
      channels_[channel].stale = true;
      ++devices_[device].silences;
    }
    tell_stale(device, now_ns);
  }
}

// The edges' source is heard of although nothing happens there, so that the merger need not guess how long to wait.
void Estimator::take_edges(std::int64_t now_ns) {
  if (options_.gpio == nullptr) return;
  const std::int64_t seen_to_ns = options_.gpio->seen_to_ns();
  Record edge;
  while (options_.gpio->pop(edge)) {
    // The interlock is never too late to matter, nor may it wait; a pulse with a wrong instant is worse than none.
    const bool urgent = edge.channel == static_cast<std::uint16_t>(Line::interlock);
    if (urgent) edge.t_ns = std::min(edge.t_ns, now_ns);
    if (urgent ? !assembler_.urgent_edge(edge) : assembler_.edge(edge) != Merger::Admission::queued)
      options_.gpio->late();
  }
  assembler_.edges_seen_to(seen_to_ns);
}

void Estimator::release(bool everything) {
  Record record;
  while (everything ? assembler_.flush(record) : assembler_.next(record)) feed(record);
}

void Estimator::feed(const Record& record) {
  if (record.kind == Kind::sample) ++channels_[record.channel].handed;
  note(pipeline_.push(record));
}

void Estimator::note(std::uint8_t change) {
  if ((change & kCompleted) != 0) {
    finished_.push(pipeline_.completed());
    log_.info(finished_line(*finished_.list()->back(), rig_));
  }
  if ((change & kStateChanged) != 0 && pipeline_.state() != state_) {
    const Dwell now = pipeline_.current();
    log_.info(state_line(state_, now), {{"DWELL_STATE", to_string(now.state)}});
    state_ = pipeline_.state();
  }
}

void Estimator::settle_counters() {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const int device = rig_.channels[i].device;
    if (device < 0 || links_[static_cast<std::size_t>(device)] == nullptr) continue;
    DeviceLink& link = *links_[static_cast<std::size_t>(device)];
    const std::uint64_t rejected = std::min(pipeline_.channel(static_cast<int>(i)).rejected, channels_[i].handed);
    link.counters(link.position(i)).settle(channels_[i].handed - rejected, rejected);
  }
}

void Estimator::publish(std::int64_t now_ns) {
  watch_.measure_rates(now_ns);
  Snapshot& to = snapshots_.back();
  to.sequence = ++sequence_;
  to.t_ns = now_ns;
  to.start_utc_ns = start_utc_ns_;
  to.dwell = pipeline_.current();
  to.finished = finished_.list();
  to.forgotten = finished_.forgotten();
  to.skipped_turns = skipped_;
  to.channels.resize(channels_.size());
  to.devices.assign(links_.size(), DeviceView{});
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const Channel& channel = rig_.channels[i];
    const ChannelNow now = pipeline_.channel(static_cast<int>(i));
    ChannelView& view = to.channels[i];
    view.value = now.value / channel.si_per_unit;
    view.heard_ns = watch_[i].heard_ns;
    view.fault = watch_[i].fault;
    view.reason = watch_[i].reason;
    view.overrange = now.overrange;
    view.condition = now.condition;
    view.condition_reason = pipeline_.condition_reason(static_cast<int>(i));
    view.rate_hz = watch_[i].rate_hz;
    view.half_width_s = channels_[i].half_width_s;
    view.gaps = now.gaps;
    if (channel.device < 0) continue;
    const auto device = static_cast<std::size_t>(channel.device);
    if (links_[device] == nullptr) continue;
    view.clock = clock_view(rig_.devices[device], assembler_.figures(device, static_cast<std::uint16_t>(i)));
    view.tally = links_[device]->counters(links_[device]->position(i)).read();
    if (view.fault == Fault::none) to.devices[device].up = true;
  }
  for (std::size_t device = 0; device < links_.size(); ++device) {
    if (links_[device] == nullptr) continue;
    for (int kind = 0; kind < kFaultCount; ++kind)
      to.devices[device].faults[static_cast<std::size_t>(kind)] = occurrences(device, static_cast<Fault>(kind));
    to.devices[device].foreign = links_[device]->foreign();
  }
  snapshots_.publish();
  published_();
}

std::uint64_t Estimator::occurrences(std::size_t device, Fault fault) const {
  return links_[device]->faults(fault) + (fault == Fault::silent     ? devices_[device].silences
                                          : fault == Fault::untimely ? devices_[device].untimely
                                                                     : 0);
}

// One line for all channels of the device that went stale together, for the same reason.
void Estimator::tell_stale(std::size_t device, std::int64_t now_ns) {
  for (const std::uint16_t first : links_[device]->channels()) {
    if (!channels_[first].stale) continue;
    const Fault fault = watch_[first].fault;
    std::vector<std::string> which;
    for (const std::uint16_t channel : links_[device]->channels()) {
      if (!channels_[channel].stale || watch_[channel].fault != fault) continue;
      channels_[channel].stale = false;
      which.push_back(rig_.channels[channel].name);
    }
    devices_[device].lines->stale(which, fault, watch_[first].reason, occurrences(device, fault), now_ns);
  }
}

void Estimator::tell_recoveries(std::size_t device, std::int64_t now_ns) {
  std::vector<std::string> which;
  std::int64_t stale_ns = 0;
  bool first = true;
  for (const std::uint16_t channel : links_[device]->channels()) {
    PerChannel& own = channels_[channel];
    if (!std::exchange(own.recovered, false) || watch_[channel].fault != Fault::none) continue;
    first = first && !own.ever_heard;
    own.ever_heard = true;
    stale_ns = std::max(stale_ns, own.stale_ns);
    which.push_back(rig_.channels[channel].name);
  }
  if (!which.empty()) devices_[device].lines->delivering(which, first, stale_ns, now_ns);
}

void Estimator::tell_counted_faults(std::int64_t now_ns) {
  for (std::size_t device = 0; device < links_.size(); ++device) {
    if (links_[device] == nullptr) continue;
    DeviceLines& lines = *devices_[device].lines;
    for (int kind = 1; kind < kFaultCount; ++kind) {
      const auto fault = static_cast<Fault>(kind);
      if (fault != Fault::missed_deadline) lines.counted(fault, occurrences(device, fault), now_ns);
    }
    if (!links_[device]->channels().empty()) lines.missed_polls(occurrences(device, Fault::missed_deadline), now_ns);
  }
}

}  // namespace dwell
