#include "core/transient/whole_hold.hpp"

#include <algorithm>
#include <numbers>

#include "core/base/chance.hpp"
#include "core/base/complex.hpp"
#include "core/base/instants.hpp"
#include "core/transient/fit_limits.hpp"
#include "core/transient/pole_search.hpp"

namespace dwell {
namespace {

// Allowed from one begin() to the next: passes over the hold, and multiplications in them, some 0.3 s. Samples beyond
// that are left out at random, in each channel by itself; twice what a channel needs is always kept. Half of the room
// is for samples before the begin of the latest fit.
constexpr int kMostPasses = 60;
constexpr double kMostMultiplications = 4e8;

// Each begin lies at this part of the time from the hold's beginning to the begin before. Not derived; no other value
// was tried.
constexpr double kEarlier = 0.6;
// Periods: from the hold's beginning to the earliest begin; the first stretch of residuals that is compared.
constexpr double kFirstStretch = 0.25;
constexpr double kTrust = 0.1;  // damping of one step: width of a relative change of a pole
// A further pole is searched in so many periods of the beginning, up to this multiple of the drive's ω. The lines are a
// quarter of a cycle over that stretch apart. At most so many lines and samples are used.
constexpr double kSearched = 4.0;
constexpr std::size_t kMostLines = 200;
constexpr double kMostSearched = 2e4;
constexpr double kOfChance = 5.0;  // multiplications to decide whether a sample is left out

// s ≥ 0; rounds down, where to_ns() rounds to the nearest.
std::int64_t whole_ns(double s) { return static_cast<std::int64_t>(kNsPerS * s); }

// A number in [0, 1) without a pattern, by an integer hash. Leaving samples out at equal steps would fold frequencies.
double chance(std::uint64_t number) {
  number = (number ^ (number >> 31)) * 0x7fb5d329728ea185U;
  number = (number ^ (number >> 27)) * 0x81dadef4bc2dd44dU;
  return static_cast<double>((number ^ (number >> 33)) >> 11) * 0x1p-53;
}

// The standard deviations of a normal number that are as improbable as χ² (Wilson and Hilferty, 1931). samples: those
// from which the variance under χ² was found.
double deviations(double chi2, double freedom, double samples) {
  const double spread = 2 / (9 * freedom);
  return (std::cbrt(chi2 / freedom) - (1 - spread)) / std::sqrt(spread * (1 + freedom / samples));
}

}  // namespace

WholeHold::WholeHold(int channels, int harmonics, int modes, const FrequencyPrior& stated)
    : fit_(channels, harmonics, modes),
      most_poles_(std::min(static_cast<std::size_t>(modes), std::size_t{ModalMotion::kMaxModes})) {
  fit_.state_omega(stated);
  poles_.reserve(most_poles_);
  trial_.reserve(most_poles_);
  channels_.resize(static_cast<std::size_t>(channels));
  for (PerChannel& channel : channels_) channel.lines.resize(kMostLines);
}

void WholeHold::begin(const Given& given) noexcept {
  passes_left_ = kMostPasses;
  from_ns_ = omega_at_ns_ = given.latest.t0_ns();
  omega_ = given.latest.omega();
  take_poles(given, given.latest);
}

bool WholeHold::earlier(const Given& given) noexcept {
  const std::int64_t first_ns = given.begin_ns + whole_ns(kFirstStretch * given.period_s);
  if (from_ns_ <= first_ns) return false;
  from_ns_ = std::max(first_ns, given.begin_ns + whole_ns(kEarlier * to_s(from_ns_ - given.begin_ns)));
  omega_ += given.latest.rate() * to_s(from_ns_ - omega_at_ns_);
  omega_at_ns_ = from_ns_;
  refine(given);
  if (!explains(given)) {
    if (passes_left_ <= 0 || !add_pole(given)) return false;
    refine(given);
    if (!explains(given)) return false;
  }
  fit_.step_poles(kTrust, given.omega_known ? 0.0 : PoleSearch::kTrustOmega);
  fit_.propagate_poles(given.omega_known);
  given.history.spend(2 * fit_.work_of_poles());
  take_poles(given, fit_);
  return true;
}

// Takes the steady lines of a fit and the poles that it shows beyond doubt. Adds each pole of the chain that none of
// these matches; each matches one at most.
void WholeHold::take_poles(const Given& given, const ModalFit& fit) noexcept {
  poles_.clear();
  for (std::size_t m = 0; m < fit.poles().size() && poles_.size() < most_poles_; ++m)
    if (fit.poles()[m].real() == 0 || fit.certain(m)) poles_.push_back(fit.poles()[m]);
  trial_ = poles_;
  for (const Complex& pole : given.chain) {
    const auto nearer = [&](Complex a, Complex b) { return std::abs(a - pole) < std::abs(b - pole); };
    const auto own = std::min_element(trial_.begin(), trial_.end(), nearer);
    if (own != trial_.end() && std::abs(*own - pole) < kSamePole * std::abs(pole))
      trial_.erase(own);
    else if (poles_.size() < most_poles_ && pole.real() < 0)
      poles_.push_back(pole);
  }
}

// Fits with these poles and ω. Returns the misfit.
double WholeHold::run(const Given& given, double omega, std::span<const Complex> poles) noexcept {
  --passes_left_;
  fit_.restart(omega, given.latest.rate(), from_ns_, poles);
  const std::uint64_t first = given.history.first_at(from_ns_), late = given.history.first_at(given.latest.t0_ns()),
                      end = given.history.first_at(given.until_ns);
  const double products = 0.5 * std::pow(fit_.parameters() + 2.0 * static_cast<double>(poles.size()) + 2, 2);
  const double room = std::max(2 * kPerParameter * fit_.parameters(),
                               kMostMultiplications / (kMostPasses * products * static_cast<double>(channels_.size())));
  for (PerChannel& channel : channels_)
    channel.low = INFINITY, channel.high = -INFINITY, channel.early_part = channel.late_part = 0.0;
  for (std::uint64_t i = first; i < end; ++i) {
    given.history.spend(1.0);
    PerChannel& channel = channels_[static_cast<std::size_t>(given.history[i].channel)];
    (i < late ? channel.early_part : channel.late_part) += 1.0;
  }
  for (PerChannel& channel : channels_) {
    const double early = channel.early_part;
    channel.early_part = std::min(1.0, 0.5 * room / std::max(1.0, early));
    channel.late_part = std::min(1.0, (room - channel.early_part * early) / std::max(1.0, channel.late_part));
  }
  for (std::uint64_t i = first; i < end; ++i) {
    const SampleHistory::Sample& s = given.history[i];
    PerChannel& channel = channels_[static_cast<std::size_t>(s.channel)];
    given.history.spend(kOfChance);
    if (!given.latest.usable(s.channel) || s.held_up ||
        chance(i) >= (i < late ? channel.early_part : channel.late_part))
      continue;
    given.history.spend(fit_.add(s.channel, s.t_ns, s.value));
    channel.low = std::min(channel.low, s.value);
    channel.high = std::max(channel.high, s.value);
  }
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const int channel = static_cast<int>(c);
    if (!given.latest.usable(channel)) continue;
    const double range = channels_[c].high - channels_[c].low;
    fit_.expect(channel, given.latest.variance(channel));
    fit_.solve(channel, given.imposed[c] != 0 ? 0.0 : range, range);
    given.history.spend(fit_.work_of_solution());
  }
  return fit_.misfit();
}

// Refines ω, steady lines and the poles that show beyond doubt.
void WholeHold::refine(const Given& given) noexcept {
  double best = run(given, omega_, poles_);
  for (int step = 0; step < PoleSearch::kManySteps && passes_left_ > 0; ++step) {
    fit_.step_poles(kTrust, given.omega_known ? 0.0 : PoleSearch::kTrustOmega);
    given.history.spend(fit_.work_of_poles());
    const auto moved = fit_.moved_poles();
    trial_.assign(moved.begin(), moved.end());
    double farthest = 0.0;  // in standard deviations
    for (std::size_t m = 0; m < trial_.size(); ++m)
      if (poles_[m].real() < 0 && !fit_.certain(m))
        trial_[m] = poles_[m];
      else if (fit_.u_pole(m) > 0)
        farthest = std::max(farthest, std::abs(trial_[m] - poles_[m]) / fit_.u_pole(m));
    if (farthest < kConverged) return;
    double by = given.omega_known ? 0.0 : fit_.moved_omega() - omega_;
    double misfit = run(given, omega_ + by, trial_);
    for (int shorter = 0; shorter < kShortened && !(misfit < best); ++shorter) {
      for (std::size_t m = 0; m < trial_.size(); ++m) trial_[m] = poles_[m] + kShorter * (trial_[m] - poles_[m]);
      by *= kShorter;
      misfit = run(given, omega_ + by, trial_);
    }
    if (!(misfit < best)) {
      run(given, omega_, poles_);
      return;
    }
    best = misfit;
    omega_ += by;
    poles_.swap(trial_);
  }
}

// Whether each channel of the latest fit is solved, by readings enough.
bool WholeHold::solved(const Given& given) const noexcept {
  bool any = false;
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const int channel = static_cast<int>(c);
    if (!given.latest.usable(channel)) continue;
    if (!fit_.usable(channel) || !(given.latest.variance(channel) > 0) ||
        fit_.samples(channel) < kPerParameter * fit_.parameters())
      return false;
    any = true;
  }
  return any;
}

// Whether the residuals are no more than the noise, over ever longer stretches of the beginning.
bool WholeHold::explains(const Given& given) noexcept {
  if (!solved(given)) return false;
  const std::int64_t until_ns = given.latest.t0_ns();
  for (PerChannel& channel : channels_) channel.squares = channel.count = 0.0;
  std::uint64_t i = given.history.first_at(from_ns_);
  for (std::int64_t length_ns = std::max<std::int64_t>(1, whole_ns(kFirstStretch * given.period_s));; length_ns *= 2) {
    const std::int64_t end_ns = std::min(until_ns, from_ns_ + length_ns);
    for (; i < given.history.end() && given.history[i].t_ns < end_ns; ++i) {
      const SampleHistory::Sample& s = given.history[i];
      PerChannel& channel = channels_[static_cast<std::size_t>(s.channel)];
      // Only samples that were fitted: the residuals of others hold the errors of the fit beside the noise.
      if (!fit_.usable(s.channel) || s.held_up || chance(i) >= channel.early_part) continue;
      given.history.spend(fit_.work_of_residual());
      const double r = fit_.residual(s.channel, s.t_ns, s.value);
      channel.squares += r * r;
      channel.count += 1.0;
    }
    if (!within_noise(given)) return false;
    if (end_ns == until_ns) return true;
  }
}

// Compares χ² of the residuals, per channel and in all together, with as many degrees of freedom as there are samples.
// Those of poles and amplitudes are not subtracted: the fit rests on the whole hold, of which this stretch is a part.
// So χ² comes out too small. Where most samples are left out, four early ones a parameter remain. χ² of C channels with
// p parameters each is then low by up to √(Cp/8) standard deviations: five for 8 channels of 25. There the 4 of
// sigmas::kShown are about 9.
bool WholeHold::within_noise(const Given& given) const noexcept {
  double chi2 = 0.0, freedom = 0.0, samples = INFINITY;
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const int channel = static_cast<int>(c);
    if (!(channels_[c].count > 0)) continue;
    const double own = channels_[c].squares / given.latest.variance(channel);
    if (deviations(own, channels_[c].count, given.latest.samples(channel)) > sigmas::kShown) return false;
    chi2 += own;
    freedom += channels_[c].count;
    samples = std::min(samples, given.latest.samples(channel));
  }
  return !(freedom > 0) || deviations(chi2, freedom, samples) <= sigmas::kShown;
}

// Adds a pole at the strongest line in the residuals of the beginning. It replaces the first pole that does not show,
// if there is one. false: there is no room, or no residual.
bool WholeHold::add_pole(const Given& given) noexcept {
  std::size_t at = 0;
  while (at < poles_.size() && (poles_[at].real() == 0 || fit_.certain(at))) ++at;
  if (at == most_poles_) return false;
  const double stretch_s = std::min(to_s(given.latest.t0_ns() - from_ns_), kSearched * given.period_s);
  const double grid = 0.5 * std::numbers::pi / stretch_s;
  const auto lines = std::clamp(static_cast<std::size_t>(kHighestSearched * omega_ / grid), std::size_t{1}, kMostLines);
  const std::uint64_t first = given.history.first_at(from_ns_),
                      end = given.history.first_at(from_ns_ + whole_ns(stretch_s));
  const double part = kMostSearched / std::max(1.0, static_cast<double>(end - first));
  for (PerChannel& channel : channels_) std::fill(channel.lines.begin(), channel.lines.end(), Complex{});
  for (std::uint64_t i = first; i < end; ++i) {
    const SampleHistory::Sample& s = given.history[i];
    if (!fit_.usable(s.channel) || s.held_up || chance(i) >= part) continue;
    given.history.spend(kOfLine * static_cast<double>(lines));
    std::vector<Complex>& sums = channels_[static_cast<std::size_t>(s.channel)].lines;
    const Complex step = std::polar(1.0, grid * to_s(s.t_ns - from_ns_));
    Complex turned = fit_.residual(s.channel, s.t_ns, s.value) * step;
    for (std::size_t k = 0; k < lines; ++k, turned *= step) sums[k] += turned;
  }
  double strongest = 0.0, found = 0.0;
  for (std::size_t k = 0; k < lines; ++k) {
    double power = 0.0;
    for (std::size_t c = 0; c < channels_.size(); ++c)
      if (const int channel = static_cast<int>(c); fit_.usable(channel) && given.imposed[c] == 0)
        power += std::norm(channels_[c].lines[k]) / given.latest.variance(channel);
    if (power > strongest) strongest = power, found = grid * static_cast<double>(k + 1);
  }
  if (!(strongest > 0) || !std::isfinite(strongest)) return false;
  const Complex pole{-1 / stretch_s, found};
  if (at < poles_.size())
    poles_[at] = pole;
  else
    poles_.push_back(pole);
  return true;
}

}  // namespace dwell
