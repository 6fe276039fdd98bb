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

enum : std::uint64_t { kNoise, kJitter, kAccident };

}  // namespace

double instant_s(const Case& about, int c, std::int64_t i) {
  const Line& line = about.lines[static_cast<std::size_t>(c)];
  const double moved = line.jitter > 0 ? line.jitter * (random_at(about.seed, c, i, kJitter).u - 0.5) : 0.0;
  return (static_cast<double>(i) + 0.5 + line.phase + moved) / line.rate_hz;
}

double reading(const Case& about, int c, std::int64_t i, double t_s) {
  const Line& line = about.lines[static_cast<std::size_t>(c)];
  double value = line.mean + about.ramps.factor(t_s) * about.motion->reading(c, t_s);
  if (line.sigma > 0) {
    const Pair random = random_at(about.seed, c, i, kNoise);
    value += line.sigma * normal_of(random.u, random.v);
  }
  if (line.hum > 0) value += line.hum * std::sin(2 * std::numbers::pi * line.hum_hz * t_s + line.hum_phase);
  if (line.step > 0) value = line.step * std::round(value / line.step);
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
