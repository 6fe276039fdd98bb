#include "tests/study/recording.hpp"

#include <cmath>
#include <numbers>

namespace dwell::study {
namespace {

// Two independent numbers in (0, 1) for sample i of channel c.
struct Pair {
  double u, v;
};
Pair random_at(std::uint64_t seed, int c, std::int64_t i, std::uint64_t purpose) noexcept {
  const std::uint64_t bits =
      mixed(seed ^ mixed((static_cast<std::uint64_t>(i) << 8) + (static_cast<std::uint64_t>(c) << 2) + purpose));
  return {unit(bits), unit(mixed(bits))};
}

enum : std::uint64_t { kNoise, kJitter, kAccident, kMishap };

// Whether an accident of this probability befalls sample i: by itself, or with all channels of its poll.
bool befalls(const Case& about, int c, std::int64_t i, double part, bool whole_scans, std::uint64_t which) {
  if (part <= 0) return false;
  return random_at(about.seed + which, whole_scans ? 0 : c, i, kMishap).u < part;
}

enum : std::uint64_t { kRepeat = 1, kBurst, kZero, kCode };

// The poll whose reading is given at poll i.
std::int64_t source_of(const Case& about, const Mishap& mishap, int c, std::int64_t i) {
  if (mishap.alternate) i -= i % 2;
  if (mishap.burst_length > 0) {
    const std::int64_t cell = i / kBurstCell;
    const Pair random = random_at(about.seed + kBurst, c, cell, kMishap);
    const auto first = cell * kBurstCell + static_cast<std::int64_t>(random.v * (kBurstCell - mishap.burst_length));
    if (random.u < mishap.bursts && i > first && i < first + mishap.burst_length) i = first;
  }
  while (i > 0 && befalls(about, c, i, mishap.repeats, mishap.whole_scans, kRepeat)) --i;
  return i;
}

}  // namespace

double instant_s(const Case& about, int c, std::int64_t i) {
  const Line& line = about.lines[static_cast<std::size_t>(c)];
  const int by = line.scan >= 0 ? line.scan : c;
  const double moved = line.jitter > 0 ? line.jitter * (random_at(about.seed, by, i, kJitter).u - 0.5) : 0.0;
  return (static_cast<double>(i) + 0.5 + line.phase + moved) / line.rate_hz;
}

namespace {

// What the transducer gives at t_s, with the noise of index i.
double measured(const Case& about, int c, std::int64_t i, double t_s) {
  const Line& line = about.lines[static_cast<std::size_t>(c)];
  double motion = about.course ? about.course->reading(c, t_s) : about.motion->reading(c, t_s);
  if (about.without_transient && !about.course) motion -= about.motion->transient(c, t_s);
  double value = line.mean + about.ramps.factor(t_s) * motion;
  if (line.sigma > 0) {
    const Pair random = random_at(about.seed, c, i, kNoise);
    value += line.sigma * normal_of(random.u, random.v);
  }
  if (line.hum > 0) value += line.hum * std::sin(2 * std::numbers::pi * line.hum_hz * t_s + line.hum_phase);
  if (line.step > 0) value = line.step * std::round(value / line.step);
  return value;
}

// The same as the device gives it.
double given(const Case& about, int c, std::int64_t i, double t_s) {
  const Mishap& mishap = about.mishaps[static_cast<std::size_t>(c)];
  const std::int64_t source = source_of(about, mishap, c, i);
  if (source != i) t_s = instant_s(about, c, source);
  std::int64_t noise = source;
  if (mishap.refresh_s > 0) {
    noise = static_cast<std::int64_t>(std::floor((t_s - mishap.refresh_phase_s) / mishap.refresh_s));
    t_s = mishap.refresh_phase_s + static_cast<double>(noise) * mishap.refresh_s;
  }
  double value = measured(about, c, noise, t_s);
  if (source == mishap.glitch) value += mishap.glitch_by;
  if (value < mishap.low) value = std::isnan(mishap.low_code) ? mishap.low : mishap.low_code;
  if (value > mishap.high) value = std::isnan(mishap.high_code) ? mishap.high : mishap.high_code;
  if (mishap.low_byte_step > 0)
    value = mishap.low_byte_step * (256 * std::floor(value / (256 * mishap.low_byte_step)) + mishap.low_byte);
  if (befalls(about, c, source, mishap.zeros, mishap.whole_scans, kZero)) value = 0.0;
  if (befalls(about, c, source, mishap.codes, false, kCode)) value = mishap.code;
  return value;
}

}  // namespace

double reading(const Case& about, int c, std::int64_t i, double t_s) {
  if (!about.mishaps.empty()) return given(about, c, i, t_s);
  double value = measured(about, c, i, t_s);
  if (about.glitches > 0 && about.sensors[static_cast<std::size_t>(c)].measures == Quantity::force &&
      random_at(about.seed, c, i, kAccident).u < about.glitches)
    value += 20 * std::abs(about.motion->phasor(c, 1));
  return value;
}

double stamp_s(const Case& about, int c, double t_s) {
  return t_s * (1 + about.clock_error) + about.lines[static_cast<std::size_t>(c)].shift_s;
}

double true_s(const Case& about, double stamp) { return stamp / (1 + about.clock_error); }

Player::Player(const Case& about) : about_(about), due_(about.lines.size()) {
  for (int c = 0; c < about.channels(); ++c) {
    due_[static_cast<std::size_t>(c)].i = -1;
    prepare(c);
  }
}

void Player::prepare(int c) {
  Due& due = due_[static_cast<std::size_t>(c)];
  due.after = due.i;
  do ++due.i;
  while (about_.lost > 0 && random_at(about_.seed, c, due.i, kAccident).v < about_.lost);
  due.t_s = instant_s(about_, c, due.i);
  due.t_ns = std::llround(1e9 * stamp_s(about_, c, due.t_s));
}

Record Player::next() {
  std::size_t first = 0;
  for (std::size_t c = 1; c < due_.size(); ++c)
    if (due_[c].t_ns < due_[first].t_ns) first = c;
  const Due due = due_[first];
  const int c = static_cast<int>(first);
  Record record;
  record.t_ns = due.t_ns;
  record.channel = static_cast<std::uint16_t>(c);
  record.t_half_ns = about_.half_ns[first];
  record.value = reading(about_, c, due.i, due.t_s);
  now_s_ = due.t_s;
  if (due.i > due.after + 1) record.flags = kGap;
  prepare(c);
  return record;
}

}  // namespace dwell::study
