#include "core/motion/table_activity.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/median.hpp"
#include "core/base/neighbour_weights.hpp"
#include "core/motion/alike_stretches.hpp"
#include "core/motion/channel_readings.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

// Factor in amplitude at which a stretch ends. The estimate suffers little from an intensity wrong by its square, 10;
// less would cut a drive that wanders into pieces that say little of their own intensity.
constexpr double kOtherKind = 3.2;
constexpr std::size_t kMostStretches = 5;
constexpr double kSpike = 40.0;       // σ from its neighbours' cubic; a knock of the table stays far below
constexpr double kMostSpikes = 0.01;  // part of a channel's readings; more of them are how it moves

struct Block {
  std::int64_t from_ns = 0;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  [[nodiscard]] double amplitude() const { return high >= low ? 0.5 * (high - low) : 0.0; }
};

std::vector<Block> blocks_of(const MotionData& data, int channel, std::int64_t length_ns) {
  std::vector<Block> blocks;
  for (const MotionReading& reading : data.readings) {
    if (reading.channel != channel) continue;
    if (blocks.empty() || reading.t_ns >= blocks.back().from_ns + length_ns) blocks.push_back({reading.t_ns});
    blocks.back().low = std::min(blocks.back().low, reading.value);
    blocks.back().high = std::max(blocks.back().high, reading.value);
  }
  return blocks;
}

// The stretches of blocks, joined where they are most alike until few are left.
std::vector<TableActivity::AmplitudeFrom> joined(const std::vector<Block>& blocks, double floor) {
  std::vector<double> logarithms;
  for (const Block& block : blocks) logarithms.push_back(std::log(std::max(block.amplitude(), floor)));
  std::vector<TableActivity::AmplitudeFrom> out;
  for (const AlikeStretches::Stretch& stretch : join_alike(logarithms, std::log(kOtherKind), kMostStretches).stretches)
    out.push_back({blocks[stretch.first].from_ns, std::exp(stretch.logarithm)});
  return out;
}

// What a cubic through the four neighbours of a reading leaves of it, in standard deviations of a noise of 1.
struct Departure {
  std::size_t reading;  // index into MotionData::readings
  double size;
};
std::vector<std::vector<Departure>> departures(const Rig& rig, const MotionData& data) {
  const std::vector<std::vector<std::size_t>> by = by_channel(rig.channels.size(), data);
  std::vector<std::vector<Departure>> out(by.size());
  for (std::size_t c = 0; c < by.size(); ++c)
    for (std::size_t i = 2; i + 2 < by[c].size(); ++i) {
      const auto at = [&](std::size_t k) -> const MotionReading& { return data.readings[by[c][k]]; };
      std::array<double, 5> t_ns{}, weights{};
      for (std::size_t a = 0; a < t_ns.size(); ++a) t_ns[a] = static_cast<double>(at(i + a - 2).t_ns - at(i).t_ns);
      neighbour_weights(t_ns.data(), 2, weights.data());
      double residual = 0.0, variance = 0.0;
      for (std::size_t a = 0; a < weights.size(); ++a) {
        residual -= weights[a] * at(i + a - 2).value;
        variance += weights[a] * weights[a];
      }
      out[c].push_back({by[c][i], std::abs(residual) / std::sqrt(variance)});
    }
  return out;
}

double median_sigma(const std::vector<Departure>& of) {
  if (of.size() < 4) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sizes;
  for (const Departure& one : of) sizes.push_back(one.size);
  return kSigmaOfMedian * median(std::move(sizes));
}

double readings_per_m(const Rig& rig, int channel) {
  return std::pow(kTwoPi * rig.excitation.frequency_hz,
                  derivative_order(rig.channels[static_cast<std::size_t>(channel)].measures));
}

}  // namespace

int activity_channel(const Rig& rig) {
  for (std::size_t c = 0; c < rig.channels.size(); ++c)
    if (shows_drive(rig.channels[c])) return static_cast<int>(c);
  return -1;
}

std::int64_t half_period_ns(const Rig& rig) { return static_cast<std::int64_t>(0.5e9 / rig.excitation.frequency_hz); }

double least_amplitude(const Rig& rig, int channel) { return rig.excitation.minimum * readings_per_m(rig, channel); }

TableActivity table_activity(const Rig& rig, const MotionData& data, const std::vector<double>& noise) {
  TableActivity out;
  out.channel = activity_channel(rig);
  out.seen = out.channel >= 0;
  if (data.readings.empty()) return out;
  out.onset_ns = data.readings.front().t_ns;
  if (!out.seen) return out;
  const auto c = static_cast<std::size_t>(out.channel);
  const double per_m = readings_per_m(rig, out.channel);
  const std::vector<Block> blocks = blocks_of(data, out.channel, half_period_ns(rig));
  const double sigma = std::isfinite(noise[c]) ? noise[c] : 0.0;
  double largest = 0.0;
  for (const Block& block : blocks) largest = std::max(largest, block.amplitude());
  out.amplitude = largest / per_m;
  if (largest > 0) out.scatter = sigma / largest;
  const double still = std::max(least_amplitude(rig, out.channel), sigma / kScatterOfNoise);
  const auto moving = std::find_if(blocks.begin(), blocks.end(), [&](const Block& b) { return b.amplitude() > still; });
  if (moving == blocks.end()) return out;
  out.moves = true;
  out.onset_ns = moving->from_ns;
  out.amplitudes = joined({moving, blocks.end()}, still);
  for (auto& from : out.amplitudes) from.amplitude /= per_m;
  return out;
}

std::vector<double> local_noise(const Rig& rig, const MotionData& data) {
  std::vector<double> out;
  for (const std::vector<Departure>& of : departures(rig, data)) out.push_back(median_sigma(of));
  return out;
}

std::size_t leave_out_spikes(const Rig& rig, MotionData& data) {
  std::vector<bool> out(data.readings.size(), false);
  for (const std::vector<Departure>& of : departures(rig, data)) {
    const double limit = kSpike * median_sigma(of);
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < of.size(); ++i) {
      const auto larger = [&](std::size_t k) { return k < of.size() && of[k].size > of[i].size; };
      if (of[i].size > limit && !larger(i - 1) && !larger(i + 1) && !larger(i - 2) && !larger(i + 2))
        found.push_back(of[i].reading);
    }
    if (static_cast<double>(found.size()) > kMostSpikes * static_cast<double>(of.size())) continue;
    for (const std::size_t i : found) out[i] = true;
  }
  return leave_out(out, data);
}

}  // namespace dwell
