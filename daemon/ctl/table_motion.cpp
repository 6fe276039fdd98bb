#include "daemon/ctl/table_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <numbers>
#include <utility>

#include "config/units.hpp"
#include "core/stream/record.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
// Periods of one amplitude that a dwell needs at least: the study finds those of three between ramps.
constexpr double kShortest = 3.0;

const Channel* table_channel(const Rig& rig) {
  for (const Channel& channel : rig.channels) {
    const bool motion = channel.measures == Quantity::displacement || channel.measures == Quantity::velocity ||
                        channel.measures == Quantity::acceleration;
    if (motion && channel.at == 0 && !channel.relative_to) return &channel;
  }
  return nullptr;
}

// The readings of the table, played again for each pass. So a recording of any length takes no memory.
class TableReadings {
 public:
  TableReadings(const Rig& rig, const Channel& channel, const RecordSource& source)
      : channel_(channel), index_(static_cast<std::size_t>(&channel - rig.channels.data())), source_(source) {}

  // Calls take(t_s, value in SI) for the readings numbered first … last - 1.
  template <class Take>
  void each(std::uint64_t first, std::uint64_t last, const Take& take) const {
    std::uint64_t number = 0;
    // Mistakes in the recording were reported when it was identified.
    (void)source_.play({}, [&](const Record& record) {
      if (record.kind != Kind::sample || record.channel != index_) return;
      const double value = channel_.scale * record.value + channel_.offset;
      const bool beyond =
          (channel_.range.low && value < *channel_.range.low) || (channel_.range.high && value > *channel_.range.high);
      if (!std::isfinite(value) || beyond) return;
      if (number >= first && number < last) take(1e-9 * static_cast<double>(record.t_ns), channel_.si_per_unit * value);
      ++number;
    });
  }

 private:
  const Channel& channel_;
  std::size_t index_;
  const RecordSource& source_;
};

// Readings in a row, in short: count, times, sum, and the two smallest and two largest values.
class ReadingRange {
 public:
  void take(double t_s, double value) {
    if (count_++ == 0) first_s_ = t_s;
    last_s_ = t_s;
    sum_ += value;
    take_low(value);
    take_high(value);
  }
  void take(const ReadingRange& next) {
    if (next.count_ == 0) return;
    if (count_ == 0) first_s_ = next.first_s_;
    last_s_ = next.last_s_;
    count_ += next.count_;
    sum_ += next.sum_;
    for (const double value : {next.lowest_, next.low_}) take_low(value);
    for (const double value : {next.highest_, next.high_}) take_high(value);
  }
  // Half of the readings' range, without the largest and the smallest: either may be a spike.
  [[nodiscard]] double half_range() const { return count_ < 5 ? 0.0 : 0.5 * (high_ - low_); }
  [[nodiscard]] double middle() const { return sum_ / static_cast<double>(count_); }
  [[nodiscard]] double length_s() const { return last_s_ - first_s_; }
  [[nodiscard]] double first_s() const { return first_s_; }
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  void take_low(double value) { low_ = value < lowest_ ? std::exchange(lowest_, value) : std::min(low_, value); }
  void take_high(double value) { high_ = value > highest_ ? std::exchange(highest_, value) : std::max(high_, value); }

  std::uint64_t count_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0, sum_ = 0.0;
  double lowest_ = std::numeric_limits<double>::infinity(), low_ = lowest_;
  double highest_ = -lowest_, high_ = -lowest_;
};

// Readings in a row, and the number of the first.
struct Span {
  std::uint64_t first = 0;
  ReadingRange of = {};
  [[nodiscard]] std::uint64_t end() const { return first + of.count(); }
};

// Of upward crossings of the middle, each after a dip well below it, so that noise makes none.
double crossing_frequency(const TableReadings& readings, const Span& span) {
  const double amplitude = span.of.half_range(), middle = span.of.middle();
  double first_s = kNaN;
  double last_s = kNaN;
  std::uint64_t crossings = 0;
  bool below = false;
  readings.each(span.first, span.end(), [&](double t_s, double reading) {
    const double value = reading - middle;
    if (value < -0.3 * amplitude) below = true;
    if (!below || value < 0.0) return;
    below = false;
    last_s = t_s;
    if (crossings++ == 0) first_s = last_s;
  });
  return crossings > 1 ? static_cast<double>(crossings - 1) / (last_s - first_s) : kNaN;
}

// Amplitude of mean + a sin + b cos at a frequency, by least squares.
class SineFit {
 public:
  void take(double phase, double value) {
    const Eigen::Vector3d row(1.0, std::sin(phase), std::cos(phase));
    normal_ += row * row.transpose();
    right_ += row * value;
  }
  [[nodiscard]] double amplitude() const {
    const Eigen::Vector3d x = normal_.ldlt().solve(right_);
    return std::hypot(x(1), x(2));
  }

 private:
  Eigen::Matrix3d normal_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right_ = Eigen::Vector3d::Zero();
};

double least_wander(const TableReadings& readings, const Span& span, double frequency_hz) {
  double least = std::numeric_limits<double>::infinity();
  double before = kNaN;
  ReadingRange piece;
  SineFit fit;
  const auto end_piece = [&] {
    const bool whole = piece.length_s() > 1.8 / frequency_hz;
    const double now = whole && piece.count() > 6 ? fit.amplitude() : kNaN;
    if (now > 0.0 && before > 0.0) least = std::min(least, std::fabs(now - before) / std::max(now, before));
    before = now;
    piece = {};
    fit = {};
  };
  readings.each(span.first, span.end(), [&](double t_s, double value) {
    if (piece.count() > 0 && !(t_s - piece.first_s() < 2.0 / frequency_hz)) end_piece();
    piece.take(t_s, value);
    fit.take(kTwoPi * frequency_hz * (t_s - piece.first_s()), value);
  });
  if (piece.count() > 0) end_piece();
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
  const TableReadings readings(rig, *channel, source);
  const int derivatives = channel->measures == Quantity::displacement ? 0
                          : channel->measures == Quantity::velocity   ? 1
                                                                      : 2;
  const auto displacement = [derivatives](double amplitude, double frequency_hz) {
    return amplitude / std::pow(kTwoPi * frequency_hz, derivatives);
  };

  // Pieces of two nominal periods, and the longest run of them above the minimum.
  const double nominal_hz = rig.excitation.frequency_hz;
  Span run, longest;
  ReadingRange piece;
  double loudest = 0.0;
  const auto end_piece = [&] {
    const double amplitude = piece.half_range();
    loudest = std::max(loudest, amplitude);
    if (displacement(amplitude, nominal_hz) < rig.excitation.minimum) {
      run = {run.end() + piece.count(), {}};
    } else {
      run.of.take(piece);
      if (run.of.count() > longest.of.count()) longest = run;
    }
    piece = {};
  };
  readings.each(0, UINT64_MAX, [&](double t_s, double value) {
    if (piece.count() > 0 && !(t_s - piece.first_s() < 2.0 / nominal_hz)) end_piece();
    piece.take(t_s, value);
  });
  if (piece.count() > 0) end_piece();
  motion.amplitude = displacement(loudest, nominal_hz);
  if (longest.of.count() < 5) return motion;
  motion.moving_s = longest.of.length_s();
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
