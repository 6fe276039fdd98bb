#include "core/drive/next_pulse.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/chance.hpp"
#include "core/base/instants.hpp"

namespace dwell {
namespace {

constexpr double kLeast = 0.02, kMost = 0.2;  // bounds of allowed(), in periods

}  // namespace

void NextPulse::begin(double T_s) noexcept {
  guess_s_ = T_s;
  count_ = 0;
}

void NextPulse::take(std::int64_t t_ns, std::int64_t k) noexcept {
  newest_ns_ = t_ns;
  newest_k_ = k;
  recent_[count_++ % kRecent] = {t_ns, k};
  fit();
}

double NextPulse::periods_to(std::int64_t t_ns) const noexcept { return (to_s(t_ns - newest_ns_) - due_s_) / T_s_; }

double NextPulse::allowed() const noexcept {
  // Too few pulses tell little of their jitter.
  return count_ < kRecent ? kJitter : std::clamp(sigmas::kPlain * spread_s_ / T_s_, kLeast, kMost);
}

void NextPulse::fit() noexcept {
  const std::size_t count = std::min(count_, kRecent);
  double mean_k = 0.0, mean_t = 0.0, kk = 0.0, kt = 0.0, tt = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    mean_k += static_cast<double>(recent_[i].k - newest_k_) / static_cast<double>(count);
    mean_t += to_s(recent_[i].t_ns - newest_ns_) / static_cast<double>(count);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double k = static_cast<double>(recent_[i].k - newest_k_) - mean_k;
    const double t = to_s(recent_[i].t_ns - newest_ns_) - mean_t;
    kk += k * k;
    kt += k * t;
    tt += t * t;
  }
  T_s_ = kk > 0 ? kt / kk : guess_s_;
  due_s_ = kk > 0 ? mean_t - T_s_ * mean_k : 0.0;
  spread_s_ = count > 2 ? std::sqrt(std::max(0.0, tt - T_s_ * kt) / static_cast<double>(count - 2)) : 0.0;
}

}  // namespace dwell
