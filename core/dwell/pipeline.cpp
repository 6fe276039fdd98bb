#include "core/dwell/pipeline.hpp"

#include "core/dwell/pipeline_impl.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {

std::uint8_t Pipeline::Impl::push(const Record& record) {
  changes = kNothing;
  take_record(record);
  if (states.changed()) changes |= kStateChanged;
  return changes;
}

void Pipeline::Impl::take_record(const Record& record) {
  if (!concerns_pipeline(record.kind)) return;
  if (at.origin_ns == INT64_MIN) {
    at.origin_ns = now_ns = record.t_ns;
  }
  if (record.t_ns < now_ns || record.t_ns > Pipeline::kLatest_ns) {  // out of order, or no instant: refused
    if (record.kind == Kind::sample && record.channel < live.count()) live[record.channel].refuse();
    return;
  }
  now_ns = record.t_ns;
  advance();
  switch (record.kind) {
    case Kind::sample:
      sample(record);
      break;
    case Kind::channel_state:
      if (record.channel < live.count()) live[record.channel].tell(static_cast<Fault>(record.flags));
      break;
    case Kind::action:
      if (record.flags == static_cast<std::uint8_t>(Action::rearm)) rearm();
      break;
    case Kind::edge:
      edge(record);
      break;
    default:  // time goes on
      break;
  }
}

std::size_t Pipeline::Impl::gather_in_block(std::span<const Record> records, std::size_t most) {
  const std::int64_t end_ns = std::min(blocks().open_end_ns(), Pipeline::kLatest_ns);
  const auto channels = static_cast<std::size_t>(live.count());
  PlainRun* const run_of = runs.data();
  for (std::size_t c = 0; c < channels; ++c) live[static_cast<int>(c)].begin(run_of[c], omega());
  std::int64_t newest_ns = now_ns;
  std::size_t n = 0;
  for (const Record& record : records.first(std::min(records.size(), most))) {
    const bool sampled = record.kind == Kind::sample;
    if ((!sampled && record.kind != Kind::tick) || record.t_ns < newest_ns || record.t_ns >= end_ns) break;
    newest_ns = record.t_ns;
    if (sampled && record.channel < channels)
      run_of[record.channel].add(record.t_ns, record.value, record.t_half_ns, record.flags != 0);
    ++n;
  }
  return n;
}

// The judgements of a channel depend on its own readings alone, and on ω, which stays within a block. So the plain
// readings of a channel are judged at once, ahead of the other channels' earlier ones. All else goes in the stream's
// order. The result is that of push().
[[gnu::flatten]] std::size_t Pipeline::Impl::take_in_block(std::span<const Record> records) {
  if (!blocks().is_open()) return 0;
  PlainRun* const run_of = runs.data();
  const std::size_t channels = runs.size(), most = PlainRun::kMost * std::max<std::size_t>(channels, 1);
  std::size_t taken = 0;
  for (std::size_t n = most; n == most; taken += n) {
    n = gather_in_block(records.subspan(taken), most);
    for (std::size_t c = 0; c < channels; ++c)
      if (run_of[c].count() >= PlainRun::kFewest)
        live[static_cast<int>(c)].take_plain(run_of[c], omega());
      else
        run_of[c].close();
    for (const Record& record : records.subspan(taken, n)) {
      now_ns = record.t_ns;
      if (record.kind != Kind::sample) continue;
      if (record.channel < channels && run_of[record.channel].pop()) {
        live.plain_sample(record);
        take(record.channel, live[record.channel], {record.t_ns, record.value, record.t_half_ns});
      } else {
        sample(record);
      }
    }
  }
  return taken;
}

void Pipeline::Impl::advance() {
  if (!blocks().is_open()) {
    data.open(now_ns);
    return;
  }
  if (now_ns < blocks().open_end_ns()) return;
  const auto quarter_ns = to_ns(period_s() / kQuarters);
  if (now_ns - blocks().open_end_ns() > Blocks::kFine * quarter_ns) {
    data.close();
    lose_data();
    data.clear();
    data.open(now_ns);
    return;
  }
  while (now_ns >= blocks().open_end_ns()) {
    const std::int64_t end = blocks().open_end_ns();
    data.close();
    on_block(end);
    data.open(end);
  }
}

void Pipeline::Impl::sample(const Record& record) {
  const int c = record.channel;
  if (c >= live.count()) return;
  live.sample(record, omega(),
              [&](LiveChannel& channel, const LiveChannel::Reading& reading) { take(c, channel, reading); });
}

void Pipeline::Impl::take(int c, LiveChannel& channel, const LiveChannel::Reading& reading) {
  if (channel.stuck(period_s()) && !states.at_rest()) return channel.leave_out_stuck();
  const bool first = !channel.has_counted();
  const double value = channel.count(reading);
  at.last_sample_ns = std::max(at.last_sample_ns, reading.t_ns);
  if (first) data.set_reference(c, value);
  history.push(reading.t_ns, c, value, channel.intake().held_up(reading));
  const double cleaned = add_cleaned(reading.t_ns, c, value);
  if (c != drive_channel()) return;
  // A reading that was held up tells less of the drive's phase.
  tracker.add(reading.t_ns, cleaned, channel.extra_u_s(reading));
}

Pipeline::Pipeline(const Rig& rig, Slices* slices) : impl_(std::make_unique<Impl>(rig, slices)) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

std::uint8_t Pipeline::push(const Record& record) noexcept { return impl_->push(record); }

std::size_t Pipeline::push_in_block(std::span<const Record> records) noexcept { return impl_->take_in_block(records); }

std::uint8_t Pipeline::finish() {
  impl_->changes = kNothing;
  impl_->end(EndedBy::end, true);
  if (impl_->states.changed()) impl_->changes |= kStateChanged;
  return impl_->changes;
}

Dwell Pipeline::current() const { return impl_->evaluate(impl_->blocks().count(), true, true); }
DwellDraft Pipeline::current_draft() const { return impl_->draft(impl_->blocks().count(), true, true); }
const Dwell& Pipeline::completed() const noexcept { return impl_->finished.dwell(); }
bool Pipeline::may_take_long(const Record& record) const noexcept {
  return record.kind == Kind::edge || record.kind == Kind::action ||
         (impl_->blocks().is_open() && record.t_ns >= impl_->blocks().open_end_ns());
}

const SampleHistory& Pipeline::readings() const noexcept { return impl_->history; }
State Pipeline::state() const noexcept { return impl_->states.state(); }

std::complex<double> Pipeline::phasor(int channel) const noexcept {
  const Impl& p = *impl_;
  if (p.at.origin_ns == INT64_MIN) return {kNaN, kNaN};
  const int from =
      p.states.measuring() ? 0 : std::max(0, p.blocks().count() - kQuarters * p.windows.length().periods());
  const HarmonicFit fit = p.data.fit_now(channel, from, p.states.measuring(), p.now_ns);
  const Channel& about = p.rig.channels[static_cast<std::size_t>(channel)];
  const double delay = about.device >= 0 ? p.rig.devices[static_cast<std::size_t>(about.device)].delay_s : 0.0;
  if (!fit.usable) return {kNaN, kNaN};
  return fit.X[0] * std::polar(1.0, p.data.bend(p.now_ns)) /
         response(about, delay, p.data.omega_at(p.now_ns, p.omega()) / kTwoPi);
}

ChannelNow Pipeline::channel(int channel) const noexcept { return impl_->live[channel].now(impl_->period_s()); }

std::string Pipeline::condition_reason(int channel) const {
  return impl_->live[channel].condition_reason(impl_->period_s());
}

}  // namespace dwell
