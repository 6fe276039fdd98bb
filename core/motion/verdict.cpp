#include "core/motion/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/wording.hpp"

namespace dwell {
namespace {

double beyond_noise(const ChannelComparison& c) {
  return std::sqrt(std::max(0.0, c.error * c.error - c.noise * c.noise));
}

}  // namespace

void judge(ChannelComparison& channel, double accuracy, bool consistent) {
  channel.verdict = Verdict::not_verified;
  channel.reason.clear();
  if (!std::isfinite(channel.error) || !std::isfinite(channel.U)) {
    channel.reason = "nothing moved in it";
  } else if (beyond_noise(channel) - channel.U > accuracy) {
    channel.verdict = Verdict::not_adequate;
    channel.reason = "the prediction is off by " + percent(channel.error) + " ± " + percent(channel.U) +
                     " of its rms, above the " + percent(accuracy) + " asked for";
  } else if (channel.error + channel.U > accuracy) {
    channel.reason =
        channel.noise > channel.U && channel.noise > 0.5 * accuracy
            ? "its noise alone is " + percent(channel.noise) + " of its rms, too much to tell " + percent(accuracy)
            : "off by " + percent(channel.error) + " ± " + percent(channel.U) + " of its rms, too wide to tell " +
                  percent(accuracy);
  } else if (!consistent && 2 * channel.error + channel.U > accuracy) {
    channel.reason = "off by " + percent(channel.error) + " ± " + percent(channel.U) +
                     " of its rms for a cause that is not known: another motion may show as much again, above " +
                     percent(accuracy);
  } else if (!(channel.error + channel.U <= channel.beyond_steady / kBeyondSteady)) {
    channel.reason = "only " + percent(channel.beyond_steady) +
                     " of its rms is more than the steady phasors give for any chain: too little beside " +
                     percent(channel.error) + " ± " + percent(channel.U);
  } else {
    channel.verdict = Verdict::adequate;
  }
}

void judge(Verification& verification, const std::vector<std::string>& names) {
  const auto rank = [](Verdict verdict) {
    return verdict == Verdict::not_adequate ? 2 : verdict == Verdict::not_verified ? 1 : 0;
  };
  const ChannelComparison* decides = nullptr;
  verification.e_n = kNaN;
  for (const ChannelComparison& channel : verification.channels) {
    if (!channel.reason.empty())
      verification.reasons.push_back(names[static_cast<std::size_t>(channel.channel)] + ": " + channel.reason);
    if (!(verification.e_n >= channel.e_n)) verification.e_n = channel.e_n;
    if (decides == nullptr || rank(channel.verdict) > rank(decides->verdict) ||
        (rank(channel.verdict) == rank(decides->verdict) && channel.error + channel.U > decides->error + decides->U))
      decides = &channel;
  }
  if (decides == nullptr) return;
  verification.verdict = decides->verdict;
  verification.seen = decides->error;
  verification.U = decides->U;
}

}  // namespace dwell
