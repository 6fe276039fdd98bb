#include "core/motion/late_answers.hpp"

#include <algorithm>
#include <cmath>

#include "core/intake/answer_lateness.hpp"

namespace dwell {
namespace {

// Readings of one channel, as indexes into MotionData::readings.
using OneChannel = std::vector<std::size_t>;

double median_half_ns(const MotionData& data, const OneChannel& line) {
  std::vector<std::uint32_t> half;
  for (const std::size_t i : line) half.push_back(data.readings[i].half_ns);
  const auto middle = half.begin() + static_cast<std::ptrdiff_t>(half.size() / 2);
  std::nth_element(half.begin(), middle, half.end());
  return *middle;
}

// Per second: the largest between neighbours among the two certain readings before line[at], and the two after it.
double steepest_about(const MotionData& data, const OneChannel& line, std::size_t at, double held_up_ns) {
  std::vector<const MotionReading*> about;
  const auto add = [&](std::size_t i) {
    const MotionReading& reading = data.readings[line[i]];
    if (reading.half_ns <= held_up_ns) about.push_back(&reading);
    return about.size();
  };
  for (std::size_t i = at; i > 0 && add(i - 1) < 2;) --i;
  std::reverse(about.begin(), about.end());
  const std::size_t enough = about.size() + 2;
  for (std::size_t i = at + 1; i < line.size() && add(i) < enough;) ++i;
  double slope = 0.0;
  for (std::size_t i = 1; i < about.size(); ++i) {
    const auto apart_ns = static_cast<double>(about[i]->t_ns - about[i - 1]->t_ns);
    if (apart_ns > 0) slope = std::max(slope, 1e9 * std::abs(about[i]->value - about[i - 1]->value) / apart_ns);
  }
  return slope;
}

}  // namespace

std::size_t leave_out_late(const std::vector<double>& noise, MotionData& data) {
  std::vector<OneChannel> lines(noise.size());
  for (std::size_t i = 0; i < data.readings.size(); ++i)
    lines[static_cast<std::size_t>(data.readings[i].channel)].push_back(i);
  std::vector<bool> late(data.readings.size(), false);
  for (std::size_t c = 0; c < lines.size(); ++c) {
    const OneChannel& line = lines[c];
    if (line.empty()) continue;
    const double median_ns = median_half_ns(data, line);
    const double held_up_ns = AnswerLateness::kHeldUp * median_ns, by_far_ns = AnswerLateness::kByFar * median_ns;
    const auto far =
        std::count_if(line.begin(), line.end(), [&](std::size_t i) { return data.readings[i].half_ns > by_far_ns; });
    const bool rare = static_cast<double>(far) < AnswerLateness::kRare * static_cast<double>(line.size());
    for (std::size_t at = 0; at < line.size(); ++at) {
      const double half_ns = data.readings[line[at]].half_ns;
      if (half_ns <= held_up_ns) continue;
      const double moves = 1e-9 * half_ns * steepest_about(data, line, at, held_up_ns);
      late[line[at]] = (rare && half_ns > by_far_ns) || moves > AnswerLateness::kUncertain * noise[c];
    }
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < late.size(); ++i)
    if (!late[i]) data.readings[kept++] = data.readings[i];
  data.readings.resize(kept);
  return late.size() - kept;
}

}  // namespace dwell
