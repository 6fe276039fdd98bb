#include "core/pipeline.hpp"

#include "core/pipeline_impl.hpp"
#include "core/transducer.hpp"

namespace dwell {
namespace {

constexpr std::int64_t kEmptyBlocks = 64;  // without a record: the time between is skipped, not stepped through
constexpr std::int64_t kLatest_ns = std::int64_t{1} << 61;  // 73 years
constexpr double kHeldUp = 1.5;                             // of the usual turnaround
constexpr double kOnGrid = 0.01, kNoGrid = 1e9;             // steps: off a multiple; a difference of so many

// One step of Euclid's algorithm on two differences of readings: where they are of any value it ends at 0 within some
// twenty of them.
double common_step(double step, double difference) {
  if (!std::isfinite(step)) return difference;
  const double times = difference / step;
  if (!(times < kNoGrid)) return 0.0;
  const double off = std::abs(difference - step * static_cast<double>(std::llround(times)));
  return off > kOnGrid * step ? off : step;
}

}  // namespace

std::uint8_t Pipeline::Impl::push(const Record& record) {
  changes = kNothing;
  if (origin_ns == INT64_MIN) {
    origin_ns = now_ns = record.t_ns;
  }
  if (record.t_ns < now_ns ||
      record.t_ns > kLatest_ns) {  // not in order, or no instant: counted where there is something to count
    if (record.kind == Kind::sample && record.channel < live.size()) ++live[record.channel].now.rejected;
    return changes;
  }
  now_ns = record.t_ns;
  advance();
  switch (record.kind) {
    case Kind::sample:
      sample(record);
      break;
    case Kind::channel_state:
      if (record.channel < live.size()) live[record.channel].now.fault = static_cast<Fault>(record.flags);
      break;
    case Kind::action:
      if (record.flags == static_cast<std::uint8_t>(Action::rearm)) rearm();
      break;
    case Kind::edge:
      edge(record);
      break;
    case Kind::tick:
      break;
  }
  return changes;
}

void Pipeline::Impl::advance() {
  if (!blocks.is_open()) {
    open_block(now_ns);
    return;
  }
  if (now_ns < blocks.open_end_ns()) return;
  const auto quarter_ns = to_ns(period_s() / kQuarters);
  if (now_ns - blocks.open_end_ns() > kEmptyBlocks * quarter_ns) {
    blocks.close();
    lose_data();
    blocks.clear();
    open_block(now_ns);
    return;
  }
  while (now_ns >= blocks.open_end_ns()) {
    const std::int64_t end = blocks.open_end_ns();
    blocks.close();
    on_block(end);
    open_block(end);
  }
}

void Pipeline::Impl::sample(const Record& record) {
  if (record.channel >= live.size()) return;
  Live& channel = live[record.channel];
  if (record.flags & kGap) ++channel.now.gaps;
  const double value = channel.gain * record.value + channel.offset;
  if (record.t_ns <= channel.last_ns || !std::isfinite(value)) {
    ++channel.now.rejected;
    return;
  }
  transactions.sample(record);
  if (channel.last_ns != INT64_MIN) channel.sampling.add(to_s(record.t_ns - channel.last_ns));
  channel.last_ns = record.t_ns;
  if (const double step = std::abs(value - channel.now.value); step != 0) {
    channel.changed_ns = record.t_ns;
    if (channel.step > 0) channel.step = common_step(channel.step, step);
  }
  channel.now.value = value;
  channel.now.t_ns = record.t_ns;
  channel.now.fault = Fault::none;
  channel.now.overrange = value < channel.low || value > channel.high;
  if (channel.now.overrange) {
    ++channel.now.rejected;
    ++channel.overrange;
    return;
  }
  if (channel.gate.spike(value)) {
    ++channel.now.rejected;
    ++channel.spikes;
    return;
  }
  if (stuck(channel) && (state == State::settling || state == State::measuring)) {
    ++channel.now.rejected;
    return;
  }
  ++channel.now.used;
  channel.half_ns_sum += record.t_half_ns;
  channel.half_count += 1.0;
  last_sample_ns = record.t_ns;
  if (!channel.referenced) {
    blocks.set_reference(record.channel, value);
    channel.referenced = true;
  }
  history.push(record.t_ns, record.channel, value);
  const double cleaned = add_cleaned(record.t_ns, record.channel, value);
  if (record.channel != drive_channel) return;
  // A reading that was held up longer than usual tells less of the drive's phase.
  const double late_ns = std::max(0.0, record.t_half_ns - kHeldUp * channel.half_ns_sum / channel.half_count);
  watch.add(record.t_ns, cleaned, 1e-9 * late_ns);
}

Pipeline::Pipeline(const Rig& rig) : impl_(std::make_unique<Impl>(rig)) {}
Pipeline::~Pipeline() = default;
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&&) noexcept = default;

std::uint8_t Pipeline::push(const Record& record) noexcept { return impl_->push(record); }

std::uint8_t Pipeline::finish() {
  impl_->changes = kNothing;
  impl_->end(EndedBy::end, State::idle, true);
  return impl_->changes;
}

Dwell Pipeline::current() const { return impl_->evaluate(impl_->blocks.count(), true, true); }
const Dwell& Pipeline::completed() const noexcept { return impl_->finished; }
State Pipeline::state() const noexcept { return impl_->state; }

std::complex<double> Pipeline::phasor(int channel) const noexcept {
  const Impl& p = *impl_;
  if (p.origin_ns == INT64_MIN) return {kNaN, kNaN};
  const int to = p.blocks.count();
  const int from = p.state == State::measuring ? 0 : std::max(0, to - kQuarters * p.window_periods);
  if (p.state == State::measuring && p.counted_valid)
    p.counted.turned(p.omega, p.now_ns, p.window);
  else
    p.blocks.sum(from, to, p.omega, p.now_ns, p.window);
  p.blocks.add_open(p.window);
  const HarmonicFit fit = fit_harmonics(p.window, channel, p.H, 0.0);
  const Channel& about = p.rig.channels[static_cast<std::size_t>(channel)];
  const double delay = about.device >= 0 ? p.rig.devices[static_cast<std::size_t>(about.device)].delay_s : 0.0;
  if (!fit.usable) return {kNaN, kNaN};
  return fit.X[0] * std::polar(1.0, p.bend(p.now_ns)) / response(about, delay, p.omega_at(p.now_ns, p.omega) / kTwoPi);
}

ChannelNow Pipeline::channel(int channel) const noexcept {
  const Impl::Live& live = impl_->live[static_cast<std::size_t>(channel)];
  ChannelNow now = live.now;
  if (live.last_ns != INT64_MIN)
    now.condition = impl_->stuck(live) ? Condition::stuck : now.overrange ? Condition::overrange : Condition::ok;
  return now;
}

std::string Pipeline::condition_reason(int channel) const {
  const Impl::Live& live = impl_->live[static_cast<std::size_t>(channel)];
  switch (this->channel(channel).condition) {
    case Condition::stuck:
      return "stuck at one reading for " + std::to_string(to_s(live.last_ns - live.changed_ns)).substr(0, 5) + " s";
    case Condition::overrange:
      return "the newest reading is beyond its range";
    default:
      return "";
  }
}

}  // namespace dwell
