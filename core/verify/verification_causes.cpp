#include "core/verify/verification_causes.hpp"

#include <algorithm>

#include "core/base/instants.hpp"
#include "core/motion/motion_estimate.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

// Bounds the time of the search: it uses the first readings of the motion, this many divided by the model's states
// (28 000 readings for a table and two masses). An estimate may use 2.5 times as many, but the search may cost as much
// as ten estimates. Halved, long transients of slow rigs are seen in part; doubled, a contradicted rig takes minutes.
constexpr std::size_t kMostOfCauses = 200'000;

// At the instants of the motion: each stamp less its channel's stated delay.
MotionData motion_data(const Rig& rig, const std::vector<ChannelReadings>& readings, std::int64_t until_ns) {
  MotionData out;
  for (std::size_t c = 0; c < readings.size(); ++c) {
    const Channel& channel = rig.channels[c];
    if (channel.measures == Quantity::auxiliary) continue;
    const std::int64_t delay_ns = to_ns(channel.delay_s + device_delay_s(rig, channel));
    for (std::size_t i = 0; i < readings[c].t_ns.size() && readings[c].t_ns[i] <= until_ns; ++i)
      out.readings.push_back({readings[c].t_ns[i] - delay_ns, static_cast<int>(c), readings[c].value[i]});
  }
  std::stable_sort(out.readings.begin(), out.readings.end(),
                   [](const MotionReading& a, const MotionReading& b) { return a.t_ns < b.t_ns; });
  return out;
}

}  // namespace

bool asks_for_causes(const Verification& verification, const Dwell& dwell) noexcept {
  return !verification.consistent.value_or(true) || verification.verdict == Verdict::not_adequate ||
         !dwell.doubts.empty();
}

Causes find_causes(const Rig& rig, const std::vector<ChannelReadings>& readings, std::int64_t until_ns) {
  MotionOptions options;
  options.most_work = kMostOfCauses;
  MotionEstimate found = estimate_motion(rig, motion_data(rig, readings, until_ns), options);
  Causes out{std::move(found.missing), std::move(found.unchecked), {}};
  if (out.missing.empty())
    out.none = found.reason.empty() ? "fitted to these readings alone, the chain explains them" : found.reason;
  return out;
}

void tell_causes(const Causes& causes, Verification& out) {
  out.missing = causes.missing;
  out.cannot_be_checked = causes.unchecked;
  if (!causes.none.empty()) out.reasons.push_back("no cause is named: " + causes.none);
}

}  // namespace dwell
