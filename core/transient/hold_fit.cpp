#include "core/transient/hold_fit.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/transient/fit_limits.hpp"

namespace dwell {
namespace {

// One refit may cost so many multiplications, a tenth of a second, but always so many fits of the whole hold.
constexpr double kMostOfRefit = 2e8, kFewestFits = 4;
constexpr double kOfRange = 2.0;  // multiplications charged for a look at a sample

}  // namespace

HoldFit::HoldFit(const SampleHistory& history, int channels, int harmonics, int modes, const FrequencyPrior& stated)
    : history_(history),
      harmonics_(harmonics),
      believed_(channels, harmonics, modes),
      spare_(believed_),
      ranges_(static_cast<std::size_t>(channels)) {
  for (ModalFit* fit : {&believed_, &spare_}) fit->state_omega(stated);
}

void HoldFit::measure_ranges(std::span<const FittedChannel> channels) noexcept {
  for (double& range : ranges_) range = 0.0;
  for (auto i = history_.first_at(from_ns_); i < history_.end(); ++i) {
    const SampleHistory::Sample& s = history_[i];
    history_.spend(kOfRange);
    const auto c = static_cast<std::size_t>(s.channel);
    ranges_[c] = std::max(ranges_[c], std::abs(s.value - channels[c].reference));
  }
}

void HoldFit::feed(std::span<const FittedChannel> channels) noexcept {
  next_ = std::max(next_, history_.begin());
  for (; next_ < history_.end(); ++next_) {
    const SampleHistory::Sample& s = history_[next_];
    if (!channels[static_cast<std::size_t>(s.channel)].watched || s.held_up) continue;
    history_.spend(believed_.add(s.channel, s.t_ns, s.value));
  }
}

void HoldFit::solve(std::span<const FittedChannel> channels) noexcept {
  for (std::size_t c = 0; c < channels.size(); ++c) {
    if (!channels[c].watched) continue;
    believed_.solve(static_cast<int>(c), channels[c].imposed ? 0.0 : ranges_[c], ranges_[c]);
    history_.spend(believed_.work_of_solution());
  }
}

double HoldFit::anew(double omega, std::span<const std::complex<double>> poles,
                     std::span<const FittedChannel> channels) noexcept {
  --fits_left_;
  believed_.restart(omega, rate_, from_ns_, poles);
  next_ = history_.first_at(from_ns_);
  feed(channels);
  solve(channels);
  return believed_.misfit();
}

bool HoldFit::attempt(double omega, std::span<const std::complex<double>> poles,
                      std::span<const FittedChannel> channels, double& misfit) noexcept {
  std::swap(believed_, spare_);
  for (int c = 0; c < this->channels(); ++c) believed_.expect(c, spare_.variance(c));
  const double other = anew(omega, poles, channels);
  if (other < misfit || !std::isfinite(misfit)) {
    misfit = other;
    return true;
  }
  std::swap(believed_, spare_);
  return false;
}

int HoldFit::affordable(std::size_t poles) const noexcept {
  const double samples = static_cast<double>(history_.end() - history_.first_at(from_ns_));
  const double products = 0.5 * std::pow(2.0 * harmonics_ + 3 + 4 * static_cast<double>(poles), 2);
  return static_cast<int>(std::clamp(kMostOfRefit / std::max(1.0, samples * products), kFewestFits, 1000.0));
}

bool HoldFit::determined() const noexcept {
  for (int c = 0; c < channels(); ++c)
    if (believed_.usable(c) && believed_.samples(c) < kPerParameter * believed_.parameters()) return false;
  return true;
}

double HoldFit::slowest_rate() const noexcept {
  double slowest = INFINITY;
  for (const std::complex<double>& pole : believed_.poles())
    if (pole.real() < 0) slowest = std::min(slowest, -pole.real());
  return slowest;
}

}  // namespace dwell
