#include "daemon/traces/traces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dwell {
namespace {

std::size_t readings_each(std::size_t channels) {
  const std::size_t room = Traces::kReadingBytes / TraceReadings::kBytesEach / std::max<std::size_t>(channels, 1);
  return std::min(TraceReadings::kMost, room);
}

// The number as it is stored; NaN: no float32 holds it.
float kept(double value) noexcept {
  const bool fits = std::abs(value) <= double{std::numeric_limits<float>::max()};
  return fits ? static_cast<float>(value) : std::numeric_limits<float>::quiet_NaN();
}

}  // namespace

Traces::Traces(const Rig& rig)
    : bins_{TraceBins(rig.channels.size()), TraceBins(rig.channels.size()), TraceBins(rig.channels.size())} {
  traces_.reserve(rig.channels.size());
  for (const Channel& channel : rig.channels)
    traces_.push_back({channel.scale,
                       channel.offset,
                       channel.range.low.value_or(-std::numeric_limits<double>::infinity()),
                       channel.range.high.value_or(std::numeric_limits<double>::infinity()),
                       false,
                       {},
                       TraceReadings(readings_each(rig.channels.size()))});
}

void Traces::take(const Record& record) noexcept {
  advance(record.t_ns);
  if (record.kind == Kind::tick || record.channel >= traces_.size()) return;
  const std::size_t channel = record.channel;
  Trace& trace = traces_[channel];
  if (record.kind == Kind::channel_state) {
    if (record.flags != static_cast<std::uint8_t>(Fault::none)) break_trace(channel, record.t_ns);
    return;
  }
  if (record.kind != Kind::sample) return;
  const bool paused = trace.pauses.paused_before(record.t_ns);
  if (paused || (record.flags & kGap) != 0) break_trace(channel, record.t_ns);
  const double value = trace.scale * record.value + trace.offset;
  const float shown = kept(value);
  if (trace.withheld || !std::isfinite(shown) || value < trace.low || value > trace.high)
    return break_trace(channel, record.t_ns);
  trace.readings.push(record.t_ns, shown);
  for (TraceBins& bins : bins_) bins.at(channel, bins.newest()).take(shown);
}

void Traces::lost() noexcept {
  if (none()) return;
  for (std::size_t channel = 0; channel < traces_.size(); ++channel) break_trace(channel, newest_ns_);
}

void Traces::withhold(std::size_t channel, bool on) noexcept { traces_[channel].withheld = on; }

void Traces::break_trace(std::size_t channel, std::int64_t t_ns) noexcept {
  traces_[channel].readings.push(t_ns, std::numeric_limits<float>::quiet_NaN());
  for (TraceBins& bins : bins_) bins.at(channel, bins.newest()).broken = true;
}

void Traces::advance(std::int64_t t_ns) noexcept {
  if (none()) origin_ns_ = bin_ends_ns_ = t_ns;
  newest_ns_ = std::max(newest_ns_, t_ns);
  if (newest_ns_ < bin_ends_ns_) return;
  for (std::size_t i = 0; i < bins_.size(); ++i) bins_[i].advance((newest_ns_ - origin_ns_) / kWidths_ns[i]);
  bin_ends_ns_ = origin_ns_ + (bins_[0].newest() + 1) * kBin_ns;
}

std::int64_t Traces::readings_from_ns() const noexcept {
  std::int64_t from_ns = origin_ns_;
  for (const Trace& trace : traces_) from_ns = std::max(from_ns, trace.readings.oldest_ns());
  return from_ns;
}

std::size_t Traces::level_of(std::int64_t step_ns) noexcept {
  std::size_t level = kWidths_ns.size() - 1;
  while (level > 0 && kWidths_ns[level] > step_ns) --level;
  return level;
}

std::int64_t Traces::instant(double t_s) const noexcept {
  return origin_ns_ + std::llround(std::clamp(t_s, 0.0, newest_s()) * 1e9);
}

Traces::BinRange Traces::cut(std::int64_t from_ns, std::int64_t to_ns, std::int64_t step_ns) const noexcept {
  const std::int64_t first = (from_ns - origin_ns_) / step_ns, last = (to_ns - origin_ns_) / step_ns;
  return {step_ns, first, last - first + 1};
}

Traces::BinRange Traces::stretch(double from_s, double to_s, std::int64_t points) const noexcept {
  const std::int64_t to_ns = instant(to_s), from_ns = std::min(instant(from_s), to_ns);
  for (std::int64_t step_ns = kFinest_ns;; step_ns *= kRatio) {
    std::int64_t kept_ns = readings_from_ns();
    if (step_ns >= kBin_ns) {
      const std::size_t level = level_of(step_ns);
      kept_ns = origin_ns_ + bins_[level].oldest() * kWidths_ns[level];
    }
    const bool last = step_ns >= kWidths_ns.back();
    if (from_ns < kept_ns && !last) continue;
    const BinRange stretch = cut(std::max(from_ns, std::min(kept_ns, to_ns)), to_ns, step_ns);
    if (stretch.count <= points) return stretch;
  }
}

Traces::BinRange Traces::stretch_of_readings(double from_s, double to_s, std::int64_t points) const noexcept {
  const double oldest_s = seconds(readings_from_ns());
  for (std::int64_t step_ns = kFinest_ns;; step_ns *= kRatio) {
    const BinRange stretch = cut(instant(std::max(from_s, oldest_s)), instant(std::max(to_s, oldest_s)), step_ns);
    if (stretch.count <= points) return stretch;
  }
}

template <class Shown>
std::vector<TraceBin> Traces::bins_of_readings(const BinRange& stretch, std::size_t channel, Shown shown) const {
  std::vector<TraceBin> bins(static_cast<std::size_t>(stretch.count));
  const std::int64_t from_ns = origin_ns_ + stretch.first * stretch.step_ns,
                     to_ns = from_ns + stretch.count * stretch.step_ns;
  // The first bin is broken where it begins before the oldest reading that is kept.
  bins.front().broken = traces_[channel].readings.oldest_ns() > from_ns;
  traces_[channel].readings.between(from_ns, to_ns, [&](std::int64_t t_ns, float reading) {
    TraceBin& bin = bins[static_cast<std::size_t>((t_ns - from_ns) / stretch.step_ns)];
    const float value = shown(t_ns, reading);
    if (std::isfinite(value))
      bin.take(value);
    else
      bin.broken = true;
  });
  return bins;
}

std::vector<TraceBin> Traces::read(const BinRange& stretch, std::size_t channel) const {
  if (stretch.step_ns < kBin_ns)
    return bins_of_readings(stretch, channel, [](std::int64_t, float reading) { return reading; });
  const std::size_t level = level_of(stretch.step_ns);
  const std::int64_t ratio = stretch.step_ns / kWidths_ns[level];
  std::vector<TraceBin> bins(static_cast<std::size_t>(stretch.count));
  const std::int64_t from = std::max(stretch.first * ratio, bins_[level].oldest()),
                     to = std::min((stretch.first + stretch.count) * ratio - 1, bins_[level].newest());
  bins.front().broken = from > stretch.first * ratio;  // the ring no longer keeps all of its parts
  for (std::int64_t number = from; number <= to; ++number)
    bins[static_cast<std::size_t>(number / ratio - stretch.first)].merge(bins_[level].at(channel, number));
  return bins;
}

std::vector<TraceBin> Traces::read_less(const BinRange& stretch, std::size_t channel, const SteadyPart& less) const {
  return bins_of_readings(stretch, channel, [&](std::int64_t t_ns, float reading) {
    const bool holds = t_ns >= less.from_ns() && t_ns <= less.to_ns();
    return kept(holds ? reading - less.at(channel, t_ns) : kNaN);
  });
}

}  // namespace dwell
