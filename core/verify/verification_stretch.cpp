#include "core/verify/verification_stretch.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/base/median.hpp"
#include "core/base/wording.hpp"
#include "core/model/forward.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

// Of the stretch, what may go for the initial state at most.
constexpr double kInitialPart = 1.0 / 3;
// Least readings of a channel that are scored: fewer than these tell no rms to 20 %.
constexpr std::size_t kFewestScored = 16;
// Readings of the table beyond the last that is compared: what the end of a spline gets wrong decays to 0.27 of itself
// from knot to knot.
constexpr std::size_t kBeyondLast = 12;
// Periods before the end of another dwell that are kept for those readings.
constexpr double kSpare = 2.0;
// Longest step between two readings of the table, in medians, that a spline may bridge.
constexpr double kLongestStep = 3.5;
// Readings of all channels together at most: bounds the time and the memory of a verification.
constexpr std::size_t kMostReadings = 60'000;
// Readings of the steady motion of a channel at most that tell its timing noise: its part m is then known to 0.03.
constexpr std::ptrdiff_t kMostSteady = 4000;
// No standard deviation below this part of the channel's amplitude: interpolation and rounded stamps leave as much.
constexpr double kLeastSigma = 1e-5;

// The channel by which the table's motion is known best: the fewest integrals, then the least noise.
int table_channel(const Rig& rig, const Dwell& dwell) {
  int best = -1;
  const auto cost = [&](int c) {
    const auto i = static_cast<std::size_t>(c);
    const ChannelPhasor& p = dwell.phasors[i];
    return 1e3 * derivative_order(rig.channels[i].measures) + p.sigma / std::max(1e-300, std::abs(p.Y));
  };
  for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c) {
    const auto i = static_cast<std::size_t>(c);
    if (!shows_drive(rig.channels[i]) || !dwell.phasors[i].valid) continue;
    if (best < 0 || cost(c) < cost(best)) best = c;
  }
  return best;
}

// A period of the slowest natural oscillation: within it every mode shows its amplitude and its phase.
double initial_s(const Chain& chain) {
  double slowest = 0.0;
  for (const auto& value : natural_values(chain)) slowest = std::max(slowest, kTwoPi / std::abs(value));
  return slowest;
}

// The instant behind the last gap of the table's readings before until_ns; INT64_MIN: there is none.
std::int64_t behind_last_gap(const Instants& t_ns, std::int64_t until_ns) {
  if (t_ns.size() < 3) return INT64_MIN;
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < t_ns.size(); ++i) steps.push_back(t_ns[i] - t_ns[i - 1]);
  const double longest = kLongestStep * static_cast<double>(median(std::move(steps)));
  std::int64_t behind = INT64_MIN;
  for (std::size_t i = 1; i < t_ns.size() && t_ns[i] <= until_ns; ++i)
    if (static_cast<double>(t_ns[i] - t_ns[i - 1]) > longest) behind = t_ns[i];
  return behind;
}

// By which the table's transducer lags the motion: so much later are its readings of the last motion compared.
std::int64_t lag_ns(const Rig& rig, int table) {
  const Channel& channel = rig.channels[static_cast<std::size_t>(table)];
  return std::max<std::int64_t>(0, to_ns(channel.delay_s + device_delay_s(rig, channel)));
}

// Readings in [from, until], and `beyond` more; the mean taken off. Strictly increasing instants.
ChannelReadings cut(const ChannelReadings& given, std::int64_t from_ns, std::int64_t until_ns, std::size_t beyond,
                    double mean) {
  ChannelReadings out;
  for (std::size_t i = 0; i < given.t_ns.size(); ++i) {
    if (given.t_ns[i] < from_ns || (!out.t_ns.empty() && given.t_ns[i] <= out.t_ns.back())) continue;
    if (given.t_ns[i] > until_ns && beyond-- == 0) break;
    out.t_ns.push_back(given.t_ns[i]);
    out.value.push_back(given.value[i] - mean);
  }
  return out;
}

// The first readings of the steady motion of a dwell.
ChannelReadings steady_readings(const ChannelReadings& given, const Dwell& dwell) {
  const auto first =
      std::lower_bound(given.t_ns.begin(), given.t_ns.end(), to_ns(dwell.settled_s)) - given.t_ns.begin();
  const auto end = std::upper_bound(given.t_ns.begin(), given.t_ns.end(), to_ns(dwell.end_s)) - given.t_ns.begin();
  const auto last = std::clamp(end, first, first + kMostSteady);
  return {{given.t_ns.begin() + first, given.t_ns.begin() + last},
          {given.value.begin() + first, given.value.begin() + last}};
}

// The motion of a dwell up to until_s.
VerificationStretch stretch_until(const Rig& rig, const Dwell& dwell, const Chain& chain,
                                  const std::vector<ChannelReadings>& before, double until_s) {
  VerificationStretch out;
  out.readings.resize(rig.channels.size());
  out.sigma.assign(rig.channels.size(), 0.0);
  out.timing.resize(rig.channels.size());
  out.omega = kTwoPi * dwell.frequency_hz.value;
  out.table = table_channel(rig, dwell);
  if (out.table < 0) {
    out.fault = "no channel shows the table's motion";
    return out;
  }
  const Instants& of_table = before[static_cast<std::size_t>(out.table)].t_ns;
  out.until_ns = to_ns(until_s);
  if (of_table.size() < 2 * kBeyondLast || of_table.front() >= out.until_ns) {
    out.fault = "no readings from before data count, at " + brief(dwell.settled_s, 4) + " s, are there";
    return out;
  }
  const double wanted_s = initial_s(chain);
  const std::int64_t gap_ns = behind_last_gap(of_table, out.until_ns);
  const std::int64_t from_ns = std::max({of_table.front(), gap_ns, to_ns(dwell.start_s - wanted_s)});
  out.score_from_ns = from_ns + to_ns(std::min(wanted_s, kInitialPart * to_s(out.until_ns - from_ns)));
  std::size_t total = 0;
  for (std::size_t c = 0; c < rig.channels.size(); ++c)
    for (const std::int64_t t_ns : before[c].t_ns) total += t_ns >= from_ns && t_ns <= out.until_ns ? 1 : 0;
  if (total > kMostReadings)
    out.until_ns = from_ns + static_cast<std::int64_t>(static_cast<double>(out.until_ns - from_ns) *
                                                       static_cast<double>(kMostReadings) / static_cast<double>(total));
  for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c) {
    const auto i = static_cast<std::size_t>(c);
    const ChannelPhasor& phasor = dwell.phasors[i];
    if (rig.channels[i].measures == Quantity::auxiliary || !phasor.valid) continue;
    out.sigma[i] = std::max(phasor.sigma, kLeastSigma * std::abs(phasor.Y));
    const bool is_table = c == out.table;
    if (!is_table && shows_drive(rig.channels[i])) continue;  // a second transducer of the table: no prediction
    ChannelReadings cut_out =
        is_table ? cut(before[i], from_ns, out.until_ns + lag_ns(rig, out.table), kBeyondLast, phasor.mean)
                 : cut(before[i], from_ns, out.until_ns, 0, phasor.mean);
    if (!is_table) {
      const auto scored = std::count_if(cut_out.t_ns.begin(), cut_out.t_ns.end(),
                                        [&](std::int64_t t_ns) { return t_ns >= out.score_from_ns; });
      if (static_cast<std::size_t>(scored) < kFewestScored) continue;
      out.compared.push_back(c);
    }
    out.timing[i] = timing_noise_of(steady_readings(before[i], dwell), out.omega, rig.excitation.harmonics);
    out.readings[i] = std::move(cut_out);
  }
  if (out.compared.empty())
    out.fault = "only " + brief(to_s(out.until_ns - from_ns), 2) + " s of motion lie " +
                (from_ns == gap_ns
                     ? "between a gap in the readings of " + rig.channels[static_cast<std::size_t>(out.table)].name +
                           ", which ends at " + brief(to_s(gap_ns), 4) + " s, and "
                     : "before ") +
                "the data that count, at " + brief(dwell.settled_s, 4) + " s: too few readings to score";
  return out;
}

}  // namespace

std::size_t VerificationStretch::unscored(int c) const {
  const Instants& t_ns = readings[static_cast<std::size_t>(c)].t_ns;
  return static_cast<std::size_t>(std::lower_bound(t_ns.begin(), t_ns.end(), score_from_ns) - t_ns.begin());
}

std::size_t VerificationStretch::scored() const {
  std::size_t count = 0;
  for (const int c : compared) count += readings[static_cast<std::size_t>(c)].t_ns.size() - unscored(c);
  return count;
}

VerificationStretch transient_before(const Rig& rig, const Dwell& dwell, const Chain& chain,
                                     const std::vector<ChannelReadings>& before) {
  return stretch_until(rig, dwell, chain, before, dwell.settled_s);
}

VerificationStretch motion_of(const Rig& rig, const Dwell& other, const Chain& chain,
                              const std::vector<ChannelReadings>& readings, double steady_s) {
  // After the dwell's end the table may move differently.
  const double last_s = other.end_s - kSpare / other.frequency_hz.value;
  return stretch_until(rig, other, chain, readings,
                       std::max(other.settled_s, std::min(other.settled_s + steady_s, last_s)));
}

}  // namespace dwell
