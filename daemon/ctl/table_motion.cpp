#include "daemon/ctl/table_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <vector>

#include "config/units.hpp"
#include "core/stream/record.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
// Periods of one amplitude that a dwell needs at least: the study finds those of three between ramps.
constexpr double kShortest = 3.0;

struct Reading {
  double t_s;
  double value;  // SI
};
using Readings = std::vector<Reading>;
using Span = std::pair<std::size_t, std::size_t>;  // first, one behind the last

const Channel* table_channel(const Rig& rig) {
  for (const Channel& channel : rig.channels) {
    const bool motion = channel.measures == Quantity::displacement || channel.measures == Quantity::velocity ||
                        channel.measures == Quantity::acceleration;
    if (motion && channel.at == 0 && !channel.relative_to) return &channel;
  }
  return nullptr;
}

Readings readings_of(const Rig& rig, const Channel& channel, const RecordSource& source) {
  Readings readings;
  const auto index = &channel - rig.channels.data();
  // Mistakes in the recording were reported when it was identified.
  (void)source.play({}, [&](const Record& record) {
    if (record.kind != Kind::sample || record.channel != index) return;
    const double value = channel.scale * record.value + channel.offset;
    const bool beyond =
        (channel.range_low && value < *channel.range_low) || (channel.range_high && value > *channel.range_high);
    const double t_s = 1e-9 * static_cast<double>(record.t_ns);
    if (std::isfinite(value) && !beyond) readings.push_back({t_s, channel.si_per_unit * value});
  });
  return readings;
}

std::size_t end_of(const Readings& readings, std::size_t first, double duration_s) {
  std::size_t end = first;
  while (end < readings.size() && readings[end].t_s - readings[first].t_s < duration_s) ++end;
  return end;
}

// Half of what the readings span, the outermost on either side left out: it may be a spike.
double half_range(const Readings& readings, Span span) {
  std::vector<double> values;
  for (std::size_t i = span.first; i < span.second; ++i) values.push_back(readings[i].value);
  if (values.size() < 5) return 0.0;
  std::sort(values.begin(), values.end());
  return 0.5 * (values[values.size() - 2] - values[1]);
}

// Of upward crossings of the middle, each after a dip well below it, so that noise makes none.
double crossing_frequency(const Readings& readings, Span span) {
  const double amplitude = half_range(readings, span);
  double middle = 0.0;
  for (std::size_t i = span.first; i < span.second; ++i) middle += readings[i].value;
  middle /= static_cast<double>(span.second - span.first);
  double first_s = kNaN;
  double last_s = kNaN;
  int crossings = 0;
  bool below = false;
  for (std::size_t i = span.first; i < span.second; ++i) {
    const double value = readings[i].value - middle;
    if (value < -0.3 * amplitude) below = true;
    if (!below || value < 0.0) continue;
    below = false;
    last_s = readings[i].t_s;
    if (crossings++ == 0) first_s = last_s;
  }
  return crossings > 1 ? (crossings - 1) / (last_s - first_s) : kNaN;
}

// Of mean + a sin + b cos at this frequency, by least squares.
double fitted_amplitude(const Readings& readings, Span span, double frequency_hz) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = span.first; i < span.second; ++i) {
    const double phase = kTwoPi * frequency_hz * (readings[i].t_s - readings[span.first].t_s);
    const Eigen::Vector3d row(1.0, std::sin(phase), std::cos(phase));
    normal += row * row.transpose();
    right += row * readings[i].value;
  }
  const Eigen::Vector3d x = normal.ldlt().solve(right);
  return std::hypot(x(1), x(2));
}

double least_wander(const Readings& readings, Span span, double frequency_hz) {
  double least = std::numeric_limits<double>::infinity();
  double before = kNaN;
  for (std::size_t first = span.first; first < span.second;) {
    const std::size_t end = std::min(span.second, end_of(readings, first, 2.0 / frequency_hz));
    const bool whole = readings[end - 1].t_s - readings[first].t_s > 1.8 / frequency_hz;
    const double now = whole && end - first > 6 ? fitted_amplitude(readings, {first, end}, frequency_hz) : kNaN;
    if (now > 0.0 && before > 0.0) least = std::min(least, std::fabs(now - before) / std::max(now, before));
    before = now;
    first = end;
  }
  return std::isfinite(least) ? least : kNaN;
}

// As the rig file has it.
std::string plain(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.6g", value);
  return text.data();
}

std::string percent(double part) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), part < 0.0995 ? "%.2g %%" : "%.0f %%", 100.0 * part);
  return text.data();
}

}  // namespace

TableMotion table_motion(const Rig& rig, const RecordSource& source) {
  TableMotion motion;
  const Channel* channel = table_channel(rig);
  if (channel == nullptr) return motion;
  motion.channel = channel->name;
  const Readings readings = readings_of(rig, *channel, source);
  const int derivatives = channel->measures == Quantity::displacement ? 0
                          : channel->measures == Quantity::velocity   ? 1
                                                                      : 2;
  const auto displacement = [derivatives](double amplitude, double frequency_hz) {
    return amplitude / std::pow(kTwoPi * frequency_hz, derivatives);
  };

  // Pieces of two nominal periods, and the longest run of them above the minimum.
  const double nominal_hz = rig.excitation.frequency_hz;
  Span run{0, 0}, longest{0, 0};
  double loudest = 0.0;
  for (std::size_t first = 0; first < readings.size();) {
    const std::size_t end = end_of(readings, first, 2.0 / nominal_hz);
    const double amplitude = half_range(readings, {first, end});
    loudest = std::max(loudest, amplitude);
    if (displacement(amplitude, nominal_hz) < rig.excitation.minimum) {
      run = {end, end};
    } else {
      run.second = end;
      if (run.second - run.first > longest.second - longest.first) longest = run;
    }
    first = end;
  }
  motion.amplitude = displacement(loudest, nominal_hz);
  if (longest.second - longest.first < 5) return motion;
  motion.moving_s = readings[longest.second - 1].t_s - readings[longest.first].t_s;
  motion.frequency_hz = crossing_frequency(readings, longest);
  if (!(motion.frequency_hz > 0.0)) return motion;
  motion.amplitude = displacement(loudest, motion.frequency_hz);
  motion.wander = least_wander(readings, longest, motion.frequency_hz);
  return motion;
}

std::string why_no_dwell(const Rig& rig, const TableMotion& motion) {
  const Excitation& e = rig.excitation;
  const char* unit = config::si_unit(Quantity::displacement, rig.motion);
  if (motion.channel.empty()) return "no dwell: no channel measures the motion of the table";
  const std::string moved = "no dwell: the table (" + motion.channel + ") moved by ";
  const std::string amplitude = join(number_text(motion.amplitude, unit, 2));
  if (!(motion.amplitude >= e.minimum))
    return moved + "at most " + amplitude + "; excitation.minimum asks for " + join(number_text(e.minimum, unit, 2));
  if (!std::isfinite(motion.frequency_hz))
    return moved + amplitude + " for " + seconds_text(motion.moving_s, 2) + ", too short to tell a frequency";
  const std::string seen = moved + amplitude + " at about " + join(number_text(motion.frequency_hz, "Hz", 3));
  // The frequency of n periods counted by crossings is known to a part of one of them.
  const double slack_hz = 0.5 / std::max(motion.moving_s, 1e-9);
  if (motion.frequency_hz < e.search_low_hz - slack_hz || motion.frequency_hz > e.search_high_hz + slack_hz) {
    return seen + ", outside of excitation.search, " + plain(e.search_low_hz) + " to " + plain(e.search_high_hz) +
           " Hz";
  }
  const double periods = motion.moving_s * motion.frequency_hz;
  if (periods < kShortest + 1.0) {
    return seen + ", for about " + seconds_text(motion.moving_s, 1) + " only; a dwell needs more than " +
           std::to_string(static_cast<int>(kShortest)) + " periods of one amplitude";
  }
  if (motion.wander > rig.tolerance) {
    return seen + ", but its amplitude changed by " + percent(motion.wander) +
           " or more within any four periods; settling.tolerance allows " + percent(rig.tolerance);
  }
  return seen + " for " + seconds_text(motion.moving_s, 1) + ", but never steadily enough for a dwell";
}

}  // namespace dwell::ctl
