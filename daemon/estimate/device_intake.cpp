#include "daemon/estimate/device_intake.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

namespace dwell {
namespace {

constexpr std::size_t kScratch = 1024;
// A stamp further ahead of the clock is a mistake of its device. Far above any stall between the clock being read and
// the rings being emptied: halved, a stall may cost good samples; doubled, a wrong stamp waits longer to be used.
constexpr std::int64_t kAhead_ns = 1'000'000'000;
// Nothing of a channel could be put in order for so long: it does not deliver.
constexpr std::int64_t kUntimely_ns = 1'000'000'000;

std::string figure(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}
std::string seconds(std::int64_t ns) { return figure("%.1f s", static_cast<double>(ns) * 1e-9); }
std::string milliseconds(std::int64_t ns) { return figure("%.0f ms", static_cast<double>(ns) * 1e-6); }

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

// Such numbers are not the transducer's. What the pipeline finds in them is a consequence, so the likely cause is added
// to its reason.
void tell_leaps(ChannelView& view) {
  if (view.condition == Condition::ok) view.condition = Condition::gated;
  view.condition_reason += std::string(view.condition_reason.empty() ? "" : "; ") +
                           "its readings differ by factors above 10¹², which no transducer spans: check type and order";
}

}  // namespace

void DeviceIntake::Heard::lost(std::int64_t t_ns, std::int64_t now_ns) noexcept {
  gap = true;
  untimely_by_ns = now_ns - t_ns;
  if (untimely_since_ns == 0) untimely_since_ns = now_ns;
}

void DeviceIntake::Heard::recover(std::int64_t for_ns) noexcept {
  recovered = true;
  stale_ns = for_ns;
}

DeviceIntake::DeviceIntake(std::size_t index, DeviceFeed feed, const Rig& rig, Assembler& assembler,
                           std::int64_t hold_back_ns, Log& log, std::int64_t now_ns)
    : index_(index),
      feed_(std::move(feed)),
      assembler_(assembler),
      hold_back_ns_(hold_back_ns),
      lines_(feed_.link->name(), feed_.rate_hz, log),
      accounts_(static_cast<std::uint16_t>(index), feed_.link->channels()),
      scratch_(kScratch) {
  for (const std::uint16_t channel : feed_.link->channels())
    channels_.emplace_back(channel, rig.channels[channel].name, feed_.rate_hz, now_ns);
}

void DeviceIntake::take(std::int64_t now_ns) {
  take_events();
  tell_stale(now_ns);
  take_samples(now_ns);
  tell_recoveries(now_ns);
}

void DeviceIntake::take_events() {
  for (StateEvent event; feed_.link->pop_event(event);) {
    for (Heard& channel : channels_) {
      if (event.channel >= 0 && event.channel != channel.index) continue;
      const std::int64_t stale_ns = event.t_ns - channel.watch.missing_since_ns();
      if (!channel.watch.said(event.t_ns, event.fault, event.reason.data())) continue;
      admit_state(channel, event.t_ns, event.fault);
      channel.stale = event.fault != Fault::none;
      channel.recovered = !channel.stale;
      if (channel.recovered) channel.stale_ns = stale_ns;
    }
  }
}

void DeviceIntake::take_samples(std::int64_t now_ns) {
  const auto enter = [this](Record& record) { enters(record); };
  const auto decided = [&](const Record& record, Merger::Admission admission) { admitted(record, admission, now_ns); };
  // A driver faster than this loop must not keep it from going on: one ring's worth at most.
  for (std::size_t left = feed_.link->capacity(); left > 0;) {
    const std::size_t taken = feed_.link->pop_samples(scratch_.data(), std::min(left, scratch_.size()));
    if (taken == 0) break;
    left -= taken;
    for (std::size_t i = 0; i < taken; ++i) {
      const Record& record = scratch_[i];
      if (stamped_ahead(record, now_ns)) continue;
      heard(record, now_ns);
      assembler_.sample(index_, record, enter, decided);
    }
  }
  assembler_.wait(index_, now_ns, enter, decided);
  const bool live = std::any_of(channels_.begin(), channels_.end(),
                                [](const Heard& channel) { return channel.watch.fault() == Fault::none; });
  if (!live) stop(now_ns);
}

void DeviceIntake::stop(std::int64_t now_ns) {
  assembler_.stopped(
      index_, [this](Record& record) { enters(record); },
      [&](const Record& record, Merger::Admission admission) { admitted(record, admission, now_ns); });
}

// A sample is proof that its channel delivers. One that delivers what cannot be put in order is not back before one
// can.
void DeviceIntake::heard(const Record& record, std::int64_t now_ns) {
  Heard& from = channel(record);
  from.leaps.see(record.value);
  if (from.watch.fault() == Fault::untimely) return from.watch.heard(now_ns);
  const std::int64_t stale_ns = record.t_ns - from.watch.missing_since_ns();
  if (!from.watch.sample(record.t_ns, now_ns)) return;
  from.recover(stale_ns);
  admit_state(from, record.t_ns, Fault::none);
}

// Dropped before it reaches clocks and merger: at its stamp it would be a wrong reading, whenever that comes.
bool DeviceIntake::stamped_ahead(const Record& record, std::int64_t now_ns) {
  if (feed_.leads || record.t_ns - now_ns <= kAhead_ns) return false;
  counters(record).ahead();
  channel(record).watch.heard(now_ns);
  channel(record).lost(record.t_ns, now_ns);
  return true;
}

// Called for each sample just before it enters the merger.
void DeviceIntake::enters(Record& record) {
  Heard& from = channel(record);
  from.half_width_s = record.t_half_ns * 1e-9;
  if (from.gap) record.flags |= kGap;
}

void DeviceIntake::admitted(const Record& record, Merger::Admission admission, std::int64_t now_ns) {
  Heard& from = channel(record);
  switch (admission) {
    case Merger::Admission::queued:
      from.gap = false;
      from.untimely_since_ns = 0;
      if (from.watch.fault() == Fault::untimely) {
        from.recover(now_ns - from.watch.since_ns());
        from.watch.said(now_ns, Fault::none, nullptr);
      }
      break;
    case Merger::Admission::late:
      counters(record).late();
      from.lost(record.t_ns, now_ns);
      break;
    case Merger::Admission::full:
      from.gap = true;
      counters(record).overflow();
      break;
  }
}

void DeviceIntake::admit_state(Heard& channel, std::int64_t t_ns, Fault fault) {
  Record record;
  record.t_ns = t_ns;
  record.channel = channel.index;
  record.kind = Kind::channel_state;
  record.flags = static_cast<std::uint8_t>(fault);
  // Only the newest counts: where there is no room it waits.
  channel.state.reset();
  if (!assembler_.state(index_, record)) channel.state = record;
}

void DeviceIntake::offer_states() {
  for (Heard& channel : channels_)
    if (channel.state && assembler_.state(index_, *channel.state)) channel.state.reset();
}

void DeviceIntake::account(std::int64_t now_ns) {
  // Not among its own records: those it will stamp a moment earlier would be late behind them.
  const auto enter = [this](const Record& record) { return assembler_.action(record); };
  for (std::size_t i = 0; i < channels_.size(); ++i)
    accounts_.lost(i, feed_.link->counters(static_cast<int>(i)).read(), now_ns, enter);
  for (int kind = 1; kind < kFaultCount; ++kind) {
    const auto fault = static_cast<Fault>(kind);
    accounts_.faulty(fault, occurrences(fault), now_ns, enter);
  }
}

void DeviceIntake::goes_stale(Heard& channel, Fault fault, const std::string& reason, std::int64_t now_ns) {
  if (!channel.watch.said(now_ns, fault, reason.c_str())) return;
  admit_state(channel, now_ns, fault);
  channel.stale = true;
}

void DeviceIntake::find_faults(std::int64_t now_ns) {
  find_hung(now_ns);
  tell_stale(now_ns);
  find_silence(now_ns);
  tell_stale(now_ns);
  find_untimely(now_ns);
  tell_stale(now_ns);
}

// A driver that hangs in a call takes its own channels with it and nothing else. A source that has been played to its
// end has nothing left to turn for.
void DeviceIntake::find_hung(std::int64_t now_ns) {
  const std::int64_t still_ns = now_ns - feed_.link->last_turn_ns();
  const bool hung_before = std::exchange(hangs_, still_ns > kHung_ns && !all(Fault::end_of_data));
  if (!hangs_ || hung_before) return;
  ++silences_;
  const std::string reason = "its driver hangs: no turn of its thread for " + seconds(still_ns);
  for (Heard& channel : channels_) goes_stale(channel, Fault::silent, reason, now_ns);
}

void DeviceIntake::find_silence(std::int64_t now_ns) {
  for (Heard& channel : channels_) {
    if (!channel.watch.fell_silent(now_ns)) continue;
    admit_state(channel, now_ns, Fault::silent);
    channel.stale = true;
    ++silences_;
  }
}

void DeviceIntake::find_untimely(std::int64_t now_ns) {
  for (Heard& channel : channels_) {
    const Fault fault = channel.watch.fault();
    const bool coming = now_ns - channel.watch.heard_ns() < kUntimely_ns;
    if (channel.untimely_since_ns == 0 || now_ns - channel.untimely_since_ns < kUntimely_ns || !coming ||
        (fault != Fault::none && fault != Fault::silent))
      continue;
    const std::int64_t by_ns = channel.untimely_by_ns;
    goes_stale(channel, Fault::untimely,
               by_ns < 0 ? "every reading is stamped ahead of the clock, the newest by " + seconds(-by_ns)
                         : "every reading comes too late to be put in order: the newest " + milliseconds(by_ns) +
                               " after its stamp, and " + milliseconds(hold_back_ns_) + " are waited for",
               now_ns);
    ++untimely_;
  }
}

void DeviceIntake::settle(const StreamAccounts& accounts) {
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    const Measurement::Fate fate = accounts.fate(channels_[i].index);
    feed_.link->counters(static_cast<int>(i)).settle(fate.used, fate.rejected);
  }
}

void DeviceIntake::show(const Rig& rig, const Pipeline& pipeline, const StreamAccounts& accounts, std::int64_t now_ns,
                        Snapshot& to) {
  DeviceView& device = to.devices[index_];
  device.name = feed_.link->name();
  device.driver = feed_.driver;
  device.recorded = feed_.recorded;
  device.up = false;
  device.ended = !channels_.empty() && all(Fault::end_of_data);
  for (int kind = 0; kind < kFaultCount; ++kind)
    device.faults[static_cast<std::size_t>(kind)] = occurrences(static_cast<Fault>(kind));
  device.foreign = feed_.link->foreign();
  for (std::size_t i = 0; i < channels_.size(); ++i) {
    Heard& from = channels_[i];
    from.watch.measure_rate(now_ns);
    const ChannelNow now = pipeline.channel(from.index);
    ChannelView& view = to.channels[from.index];
    view.value = now.value / rig.channels[from.index].si_per_unit;
    view.heard_ns = from.watch.heard_ns();
    view.fault = from.watch.fault();
    view.reason = from.watch.reason();
    view.overrange = now.overrange;
    view.condition = now.condition;
    view.condition_reason = pipeline.condition_reason(from.index);
    if (from.leaps.found()) tell_leaps(view);
    view.rate_hz = from.watch.rate_hz();
    view.clock = clock_view(rig.devices[index_], assembler_.figures(index_, from.index));
    view.half_width_s = from.half_width_s;
    view.gaps = accounts.gaps(from.index);
    view.tally = feed_.link->counters(static_cast<int>(i)).read();
    device.up = device.up || view.fault == Fault::none;
  }
}

bool DeviceIntake::all(Fault fault) const noexcept {
  return std::all_of(channels_.begin(), channels_.end(),
                     [fault](const Heard& channel) { return channel.watch.fault() == fault; });
}

std::uint64_t DeviceIntake::occurrences(Fault fault) const noexcept {
  return feed_.link->faults(fault) + (fault == Fault::silent ? silences_ : fault == Fault::untimely ? untimely_ : 0);
}

// One line for all channels of the device that went stale together, for the same reason.
void DeviceIntake::tell_stale(std::int64_t now_ns) {
  for (const Heard& first : channels_) {
    if (!first.stale) continue;
    const Fault fault = first.watch.fault();
    std::vector<std::string> which;
    for (Heard& channel : channels_)
      if (channel.watch.fault() == fault && std::exchange(channel.stale, false)) which.push_back(channel.name);
    lines_.stale(which, fault, first.watch.reason(), occurrences(fault), now_ns);
  }
}

void DeviceIntake::tell_recoveries(std::int64_t now_ns) {
  std::vector<std::string> which;
  std::int64_t stale_ns = 0;
  bool first = true;
  for (Heard& channel : channels_) {
    if (!std::exchange(channel.recovered, false) || channel.watch.fault() != Fault::none) continue;
    first = first && !channel.ever_heard;
    channel.ever_heard = true;
    stale_ns = std::max(stale_ns, channel.stale_ns);
    which.push_back(channel.name);
  }
  if (!which.empty()) lines_.delivering(which, first, stale_ns, now_ns);
}

void DeviceIntake::tell_counted_faults(std::int64_t now_ns) {
  for (int kind = 1; kind < kFaultCount; ++kind) {
    const auto fault = static_cast<Fault>(kind);
    if (fault != Fault::missed_deadline) lines_.counted(fault, occurrences(fault), now_ns);
  }
  if (!channels_.empty()) lines_.missed_polls(occurrences(Fault::missed_deadline), now_ns);
}

void DeviceIntake::tell_end() { lines_.end(occurrences(Fault::missed_deadline)); }

}  // namespace dwell
