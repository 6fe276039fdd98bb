#include "core/motion/late_answers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.hpp"
#include "core/intake/answer_lateness.hpp"
#include "core/intake/rounding_step.hpp"
#include "core/motion/channel_readings.hpp"

namespace dwell {
namespace {

// Readings of one channel, as indexes into MotionData::readings, by time.
using OneChannel = std::vector<std::size_t>;

double median_half_ns(const MotionData& data, const OneChannel& channel) {
  std::vector<std::uint32_t> half;
  for (const std::size_t i : channel) half.push_back(data.readings[i].half_ns);
  return median(std::move(half));
}

// Standard deviation of the rounding, SI; 0: there is none.
double rounding_noise(const MotionData& data, const OneChannel& channel) {
  RoundingStep rounding;
  for (std::size_t i = 1; i < channel.size(); ++i)
    rounding.add(data.readings[channel[i]].value - data.readings[channel[i - 1]].value);
  return std::isfinite(rounding.step()) ? rounding.step() / std::sqrt(12.0) : 0.0;
}

// Steepest slope about a reading, per second: between neighbours among the last two certain readings before it and the
// first two after it.
double steepest_about(const MotionData& data, const OneChannel& certain, std::size_t reading) {
  const auto after = std::lower_bound(certain.begin(), certain.end(), reading);
  const auto from = after - std::min<std::ptrdiff_t>(2, after - certain.begin());
  const auto to = after + std::min<std::ptrdiff_t>(2, certain.end() - after);
  double slope = 0.0;
  for (auto at = from; at != to && at + 1 != to; ++at) {
    const MotionReading &one = data.readings[*at], &next = data.readings[*(at + 1)];
    const auto apart_ns = static_cast<double>(next.t_ns - one.t_ns);
    if (apart_ns > 0) slope = std::max(slope, 1e9 * std::abs(next.value - one.value) / apart_ns);
  }
  return slope;
}

void mark_late(const MotionData& data, const OneChannel& channel, double noise, std::vector<bool>& late) {
  const double median_ns = median_half_ns(data, channel);
  OneChannel certain, held_up;
  std::size_t far = 0;
  for (const std::size_t i : channel) {
    const double half_ns = data.readings[i].half_ns;
    (half_ns > AnswerLateness::kHeldUp * median_ns ? held_up : certain).push_back(i);
    far += half_ns > AnswerLateness::kByFar * median_ns ? 1 : 0;
  }
  if (held_up.empty()) return;
  const bool rare = static_cast<double>(far) < AnswerLateness::kRare * static_cast<double>(channel.size());
  const double least = AnswerLateness::kUncertain * std::fmax(noise, rounding_noise(data, channel));
  for (const std::size_t i : held_up) {
    const double half_ns = data.readings[i].half_ns;
    const bool by_far = rare && median_ns > 0 && half_ns > AnswerLateness::kByFar * median_ns;
    late[i] = by_far || 1e-9 * half_ns * steepest_about(data, certain, i) > least;
  }
}

}  // namespace

std::size_t leave_out_late(const std::vector<double>& noise, MotionData& data) {
  const std::vector<OneChannel> channels = by_channel(noise.size(), data);
  std::vector<bool> late(data.readings.size(), false);
  for (std::size_t c = 0; c < channels.size(); ++c)
    if (!channels[c].empty()) mark_late(data, channels[c], noise[c], late);
  return leave_out(late, data);
}

}  // namespace dwell
