#include "core/motion/rig_mistakes.hpp"

#include <algorithm>
#include <cmath>

#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;

// A coefficient this many standard uncertainties below zero is impossible. A healthy one near zero gets there once in
// 30 000.
constexpr double kNegative = 4.0;

// SI = gain · raw + offset.
double gain_of(const Channel& channel) { return channel.si_per_unit * channel.scale; }
double offset_of(const Channel& channel) { return channel.si_per_unit * channel.offset; }

}  // namespace

std::vector<RigMistake> rig_mistakes(const Rig& rig) {
  std::vector<RigMistake> out;
  const auto counts = [&](int c) { return rig.channels[static_cast<std::size_t>(c)].measures != Quantity::auxiliary; };
  const auto channels = static_cast<int>(rig.channels.size());
  for (int c = 0; c < channels; ++c) {
    if (!counts(c)) continue;
    out.push_back({c, -1});
    for (int other = c + 1; other < channels; ++other)
      if (counts(other)) out.push_back({c, other});
  }
  return out;
}

std::string name_of(const Rig& rig, const RigMistake& mistake) {
  const std::string& name = rig.channels[static_cast<std::size_t>(mistake.channel)].name;
  if (mistake.other < 0) return "sign of " + name;
  return name + " and " + rig.channels[static_cast<std::size_t>(mistake.other)].name + " swapped";
}

std::string in_words(const Rig& rig, const RigMistake& mistake) {
  return (mistake.other < 0 ? "the opposite " : "") + name_of(rig, mistake);
}

MotionData without(const Rig& rig, const MotionData& data, const RigMistake& mistake) {
  MotionData out = data;
  const Channel& channel = rig.channels[static_cast<std::size_t>(mistake.channel)];
  if (mistake.other < 0) {
    for (MotionReading& reading : out.readings)
      if (reading.channel == mistake.channel) reading.value = 2 * offset_of(channel) - reading.value;
    return out;
  }
  const Channel& other = rig.channels[static_cast<std::size_t>(mistake.other)];
  const double later_s =
      (other.delay_s + device_delay_s(rig, other)) - (channel.delay_s + device_delay_s(rig, channel));
  const auto later_ns = static_cast<std::int64_t>(std::llround(1e9 * later_s));
  for (MotionReading& reading : out.readings) {
    const bool first = reading.channel == mistake.channel, second = reading.channel == mistake.other;
    if (!first && !second) continue;
    const Channel &from = first ? channel : other, &to = first ? other : channel;
    reading.value = gain_of(to) * ((reading.value - offset_of(from)) / gain_of(from)) + offset_of(to);
    reading.t_ns -= first ? later_ns : -later_ns;
    reading.channel = first ? mistake.other : mistake.channel;
  }
  std::stable_sort(out.readings.begin(), out.readings.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  return out;
}

bool has_impossible_coefficient(const Rig& rig, const MotionFit& fit) {
  for (Index i = 0; i < 2 * rig.element_count(); ++i)
    if (fit.at.theta(i) < -kNegative * std::sqrt(fit.covariance(i, i))) return true;
  return false;
}

ChainFit chain_fit(const Rig& rig, const MotionCourse& course) {
  ChainFit out;
  if (!course.whole || !std::isfinite(course.fit.V) || course.data.readings.empty()) return out;
  const MotionModel model = course.model(rig);
  out.left = leftover(model, course.data, course.fit.at, course.noise, course.size);
  const Pass pass = evaluate(model, course.data, course.fit.at, {.derivatives = false});
  out.readings = static_cast<double>(course.data.readings.size());
  double V = course.fit.V;  // of readings in SI; below, of the device's numbers, so that swapped channels compare
  for (std::size_t c = 0; c < pass.count.size(); ++c)
    V -= pass.count[c] > 0 ? pass.count[c] * std::log(std::abs(gain_of(rig.channels[c]))) : 0.0;
  out.per_reading = V / out.readings;
  out.possible = course.reason.empty() && !has_impossible_coefficient(rig, course.fit);
  for (std::size_t a = 0; a < course.parameters.size(); ++a) {
    const Parameter& p = course.parameters[a];
    if (p.what != Unknown::noise) continue;
    const auto c = static_cast<std::size_t>(p.index);
    const double u = std::exp(course.fit.at.theta(static_cast<Index>(a))), noise = course.noise[c];
    const double left = std::sqrt(std::max(0.0, u * u - noise * noise));
    if (left > kNotLinear * course.size[c] && u > kMoreThanNoise * noise) out.possible = false;
  }
  return out;
}

}  // namespace dwell
