#include "core/intake/live_channel.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/instants.hpp"
#include "core/base/wording.hpp"
#include "core/intake/answer_lateness.hpp"

namespace dwell {
namespace {

// Part of a phasor's standard uncertainty that clipping or repeats may cost without being reported.
constexpr double kBiasMatters = 0.3;
// Part of the readings that may be left out. With more, enough bad readings also pass the gate: of 30 % zeros and 1 %
// noise an error of 30 u passed, of 10 % zeros none.
constexpr double kMostLeftOut = 0.15;

}  // namespace

double LiveChannel::extra_u_s(const Reading& reading) const noexcept {
  return 1e-9 * std::max(0.0, reading.half_ns - AnswerLateness::kHeldUp * half_ns_sum_ / half_count_);
}

void LiveChannel::begin_hold() noexcept {
  half_ns_sum_ = half_count_ = 0.0;
  // Before the hold refreshes may have been missed, or the register not known as held.
  if (intake_.held() || intake_.holding_changed()) sampling_ = {};
  intake_.begin_hold();
}

bool LiveChannel::delivers(std::int64_t now_ns, double period_s) const noexcept {
  return now_.fault == Fault::none && last_ns_ != INT64_MIN &&
         to_s(now_ns - last_ns_) <= std::max(kSilent_s, kLostPeriods * period_s);
}

bool LiveChannel::unfit(double period_s, double tolerance) const noexcept {
  return stuck(period_s) || std::max(intake_.clipping_bias(), intake_.repeat_bias()) > kToleranceShare * tolerance ||
         intake_.clustered() || intake_.left_out() > kMostLeftOut;
}

ChannelNow LiveChannel::now(double period_s) const noexcept {
  ChannelNow now = now_;
  now.rejected = out_of_order_ + stuck_ + intake_.left();
  now.used = received_ - now.rejected;
  now.condition = stuck(period_s) ? Condition::stuck : intake_.condition();
  return now;
}

double LiveChannel::turnaround_u_s() const noexcept {
  return half_count_ > 0 ? half_ns_sum_ / half_count_ * 1e-9 / std::numbers::sqrt3 : 0.0;
}

std::string LiveChannel::condition_reason(double period_s) const {
  if (!stuck(period_s)) return intake_.condition_reason();
  return "stuck at one reading for " + std::to_string(intake_.same_for_s()).substr(0, 5) + " s";
}

const char* LiveChannel::fault_name() const noexcept {
  return to_string(now_.fault == Fault::none ? Fault::silent : now_.fault);
}

std::string LiveChannel::silent_reason() const {
  if (last_ns_ == INT64_MIN && now_.fault == Fault::silent) return "no sample yet";
  return std::string("stale, ") + fault_name();
}

std::string LiveChannel::unfit_reason(double amplitude, double u, bool measuring) const {
  if (intake_.clipping_bias() * amplitude > kBiasMatters * u) return intake_.clipped_reason();
  if (intake_.repeat_bias() * amplitude > kBiasMatters * u) return intake_.repeat_reason();
  if (intake_.clustered()) return intake_.clustered_reason();
  if (intake_.left_out() > kMostLeftOut) return intake_.left_out_reason();
  if (measuring && intake_.holding_changed())
    return intake_.held() ? intake_.held_reason() +
                                ", seen only since this dwell began: re-arm, or poll at the rate of the refresh"
                          : "its refresh rate changed during this dwell (no longer held between polls): re-arm";
  return "";
}

std::vector<std::string> LiveChannel::warnings(double tolerance) const {
  std::vector<std::string> out;
  if (intake_.held())
    out.push_back(intake_.held_reason() + "; each new value counts once, at an instant known to ± " +
                  brief(1e3 * intake_.refresh_half_s(), 2) + " ms");
  if (intake_.clustered()) out.push_back(intake_.clustered_reason());
  if (std::string reason = intake_.left_out_reason(); !reason.empty()) out.push_back(std::move(reason));
  if (intake_.repeat_bias() > 0) out.push_back(intake_.repeat_reason());
  if (intake_.late() > kMostLeftOut)
    out.push_back(percent(intake_.late()) +
                  " of its readings do not count: they were answered too late; the computer or the gateway is busy");
  if (intake_.clipping_bias() > kToleranceShare * tolerance)
    out.push_back(intake_.clipped_reason() + "; choose a larger range, or a smaller amplitude, then re-arm");
  return out;
}

}  // namespace dwell
