#include "core/verify/verdict.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/wording.hpp"

namespace dwell {
namespace {

double beyond_noise(const ChannelComparison& c) {
  return std::sqrt(std::max(0.0, c.error * c.error - c.noise * c.noise));
}

struct Deviation {
  double size, U;
};

// The figures of a verdict's text. Noise is taken off the error of a consistent model and of one that is not adequate.
Deviation deviation_of(const ChannelComparison& c, bool consistent) {
  if (c.verdict == Verdict::not_adequate) return {beyond_noise(c), c.U};
  if (consistent) return {beyond_noise(c), c.U_as_is};
  return {c.error, std::max(c.U, c.U_as_is)};
}

std::string text_of(const Deviation& deviation) {
  return "off by " + percent(deviation.size) + " ± " + percent(deviation.U) + " of its rms";
}

// The largest error to expect in another motion.
double largest(const Deviation& deviation, bool consistent) {
  return (consistent ? 1 : 2) * deviation.size + deviation.U;
}

// What a channel says of the whole: 2 not adequate; 1 not verified; 0 adequate, or to be ignored as judge() says.
int rank(const ChannelComparison& c, double accuracy, bool consistent, bool others_tested) {
  if (c.verdict == Verdict::not_adequate) return 2;
  if (c.verdict == Verdict::adequate) return 0;
  return others_tested && largest(deviation_of(c, consistent), consistent) <= accuracy ? 0 : 1;
}

}  // namespace

void judge(ChannelComparison& channel, double accuracy, bool consistent) {
  channel.verdict = Verdict::not_verified;
  channel.reason.clear();
  if (!std::isfinite(channel.error) || !std::isfinite(channel.U) || !std::isfinite(channel.U_as_is)) {
    channel.reason = "no error can be computed: the channel did not move";
    return;
  }
  if (beyond_noise(channel) - channel.U > accuracy) {
    channel.verdict = Verdict::not_adequate;
    channel.reason = "the prediction is " + text_of(deviation_of(channel, consistent)) + ", above the " +
                     percent(accuracy) + " asked for";
    return;
  }
  const Deviation deviation = deviation_of(channel, consistent);
  const double at_most = largest(deviation, consistent);
  if (deviation.size + deviation.U > accuracy) {
    channel.reason = text_of(deviation) + " (noise: " + percent(channel.noise) + "): U is too large to decide at " +
                     percent(accuracy);
  } else if (at_most > accuracy) {
    channel.reason = text_of(deviation) +
                     ", which noise and stated uncertainties do not explain; it counts twice, and that is above " +
                     percent(accuracy);
  } else if (!(at_most <= channel.beyond_steady / kBeyondSteady)) {
    channel.reason = "its transient hardly tests the chain: " + percent(channel.beyond_steady) +
                     " of its rms depends on it, " + percent(kBeyondSteady * at_most) + " are needed";
  } else {
    channel.verdict = Verdict::adequate;
  }
}

void judge(Verification& verification, const std::vector<std::string>& names) {
  const bool consistent = verification.consistent.value_or(false);
  const auto tested = std::count_if(verification.channels.begin(), verification.channels.end(),
                                    [](const ChannelComparison& c) { return c.verdict == Verdict::adequate; });
  const bool most_tested = 2 * static_cast<std::size_t>(tested) > verification.channels.size();
  int decides = -1;
  verification.e_n = kNaN;
  for (const ChannelComparison& channel : verification.channels) {
    if (!channel.reason.empty())
      verification.reasons.push_back(names[static_cast<std::size_t>(channel.channel)] + ": " + channel.reason);
    if (!(verification.e_n >= channel.e_n)) verification.e_n = channel.e_n;
    const Deviation deviation = deviation_of(channel, consistent);
    const int here = rank(channel, verification.accuracy, consistent, most_tested);
    if (here < decides || (here == decides && deviation.size + deviation.U <= verification.seen + verification.U))
      continue;
    decides = here;
    verification.verdict = here == 2 ? Verdict::not_adequate : here == 1 ? Verdict::not_verified : Verdict::adequate;
    verification.seen = deviation.size;
    verification.U = deviation.U;
  }
}

}  // namespace dwell
