#include "core/whole_hold.hpp"

#include <algorithm>
#include <numbers>

#include "core/complex.hpp"

namespace dwell {
namespace {

// Of one begin() to the next: passes over the hold, and multiplications, a quarter of a second. Samples beyond what
// these allow are left out at random.
constexpr int kMostPasses = 60;
constexpr double kMostWork = 4e8;

constexpr double kEarlier = 0.6;  // of the time since the hold's beginning, from one begin to the next
constexpr double kFirst = 0.25;   // periods after it: the earliest begin, and the first stretch that is judged
constexpr int kSteps = 8;         // of refinement at one begin; each shortened so many times …
constexpr int kShortened = 2;
constexpr double kShorter = 0.3;                     // … to this part, where it made things worse
constexpr double kTrust = 0.1, kTrustOmega = 0.005;  // relative change of a pole and of ω in one step
constexpr double kConverged = 0.1;                   // of the uncertainty of a pole
constexpr double kNear = 0.1;  // relative: a chain's pole that near to one of the data is that one
// Standard deviations of what is left over. At 3 one stretch in a hundred of healthy holds ends the fits.
constexpr double kSure = 4.0;
constexpr double kSearched = 4.0;   // periods of the beginning, in which a further pole is looked for
constexpr std::size_t kLines = 64;  // from a quarter of a cycle in them on, by as much

double to_s(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }

std::int64_t to_ns(double s) { return static_cast<std::int64_t>(1e9 * s); }

// A number in [0, 1) that looks like chance.
double chance(std::uint64_t number) {
  number = (number ^ (number >> 31)) * 0x7fb5d329728ea185U;
  number = (number ^ (number >> 27)) * 0x81dadef4bc2dd44dU;
  return static_cast<double>((number ^ (number >> 33)) >> 11) * 0x1p-53;
}

}  // namespace

WholeHold::WholeHold(int channels, int harmonics, int modes, const FrequencyPrior& stated)
    : fit_(channels, harmonics, modes), most_poles_(static_cast<std::size_t>(modes)) {
  fit_.state_omega(stated);
  poles_.reserve(most_poles_);
  trial_.reserve(most_poles_);
  channels_.resize(static_cast<std::size_t>(channels));
}

void WholeHold::begin(const Given& given) noexcept {
  passes_left_ = kMostPasses;
  from_ns_ = omega_at_ns_ = given.latest.t0_ns();
  omega_ = given.latest.omega();
  take_poles(given, given.latest);
}

bool WholeHold::earlier(const Given& given) noexcept {
  const std::int64_t first_ns = given.begin_ns + to_ns(kFirst * given.period_s);
  if (from_ns_ <= first_ns) return false;
  from_ns_ = std::max(first_ns, given.begin_ns + to_ns(kEarlier * to_s(from_ns_ - given.begin_ns)));
  omega_ += given.latest.rate() * to_s(from_ns_ - omega_at_ns_);
  omega_at_ns_ = from_ns_;
  refine(given);
  if (!explains(given)) {
    if (!add_pole(given)) return false;
    refine(given);
    if (!explains(given)) return false;
  }
  if (passes_left_ <= 0) return false;
  static_cast<void>(fit_.refined(kTrust, given.omega_known ? 0.0 : kTrustOmega));
  fit_.propagate_poles(given.omega_known);
  take_poles(given, fit_);
  return true;
}

// Steady lines and what a fit shows beyond doubt, then the poles of the chain that none of these is, one for one.
void WholeHold::take_poles(const Given& given, const ModalFit& fit) noexcept {
  poles_.clear();
  for (std::size_t m = 0; m < fit.poles().size() && poles_.size() < most_poles_; ++m)
    if (fit.poles()[m].real() == 0 || fit.certain(m)) poles_.push_back(fit.poles()[m]);
  trial_ = poles_;
  for (const Complex& pole : given.chain) {
    const auto nearer = [&](Complex a, Complex b) { return std::abs(a - pole) < std::abs(b - pole); };
    const auto own = std::min_element(trial_.begin(), trial_.end(), nearer);
    if (own != trial_.end() && std::abs(*own - pole) < kNear * std::abs(pole))
      trial_.erase(own);
    else if (poles_.size() < most_poles_ && pole.real() < 0)
      poles_.push_back(pole);
  }
}

// The fit with these poles; its misfit.
double WholeHold::run(const Given& given, double omega, std::span<const Complex> poles) noexcept {
  --passes_left_;
  fit_.restart(omega, given.latest.rate(), from_ns_, poles);
  const std::uint64_t first = given.history.first_at(from_ns_), late = given.history.first_at(given.latest.t0_ns()),
                      end = given.history.first_at(given.until_ns);
  const double products = 0.5 * std::pow(fit_.parameters() + 2.0 * static_cast<double>(poles.size()) + 2, 2);
  const double room = kMostWork / (kMostPasses * products), beginning = static_cast<double>(late - first);
  const double early_part = std::min(1.0, 0.5 * room / std::max(1.0, beginning));
  const double late_part =
      std::min(1.0, (room - early_part * beginning) / std::max(1.0, static_cast<double>(end - late)));
  for (PerChannel& channel : channels_) channel.low = INFINITY, channel.high = -INFINITY;
  for (std::uint64_t i = first; i < end; ++i) {
    const SampleHistory::Sample& s = given.history[i];
    if (!given.latest.usable(s.channel) || chance(i) >= (i < late ? early_part : late_part)) continue;
    fit_.add(s.channel, s.t_ns, s.value);
    PerChannel& channel = channels_[static_cast<std::size_t>(s.channel)];
    channel.low = std::min(channel.low, s.value);
    channel.high = std::max(channel.high, s.value);
  }
  for (std::size_t c = 0; c < channels_.size(); ++c) {
    const int channel = static_cast<int>(c);
    if (!given.latest.usable(channel)) continue;
    const double range = channels_[c].high - channels_[c].low;
    fit_.expect(channel, given.latest.variance(channel));
    fit_.solve(channel, given.imposed[c] != 0 ? 0.0 : range, range);
  }
  return fit_.misfit();
}

// Moves the poles that show beyond doubt, and ω.
void WholeHold::refine(const Given& given) noexcept {
  double best = run(given, omega_, poles_);
  for (int step = 0; step < kSteps && passes_left_ > 0; ++step) {
    const auto moved = fit_.refined(kTrust, given.omega_known ? 0.0 : kTrustOmega);
    trial_.assign(moved.begin(), moved.end());
    double farthest = 0.0;  // in standard deviations
    for (std::size_t m = 0; m < trial_.size(); ++m)
      if (poles_[m].real() < 0 && !fit_.certain(m))
        trial_[m] = poles_[m];
      else
        farthest = std::max(farthest, std::abs(trial_[m] - poles_[m]) / fit_.u_pole(m));
    if (farthest < kConverged) return;
    double by = given.omega_known ? 0.0 : fit_.refined_omega() - omega_;
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

// Over ever longer stretches the residuals are no more than the noise, in each channel and in all together.
bool WholeHold::explains(const Given& given) noexcept {
  const std::int64_t until_ns = given.latest.t0_ns();
  for (PerChannel& channel : channels_) channel.squares = channel.count = 0.0;
  std::uint64_t i = given.history.first_at(from_ns_);
  for (std::int64_t length_ns = to_ns(kFirst * given.period_s);; length_ns *= 2) {
    const std::int64_t end_ns = std::min(until_ns, from_ns_ + length_ns);
    for (; i < given.history.end() && given.history[i].t_ns < end_ns; ++i) {
      const SampleHistory::Sample& s = given.history[i];
      if (!fit_.usable(s.channel)) continue;
      const double r = fit_.residual(s.channel, s.t_ns, s.value);
      PerChannel& channel = channels_[static_cast<std::size_t>(s.channel)];
      channel.squares += r * r;
      channel.count += 1.0;
    }
    double beyond = 0.0, variance = 0.0;
    for (std::size_t c = 0; c < channels_.size(); ++c) {
      const double count = channels_[c].count;
      const int channel = static_cast<int>(c);
      if (!(count > 0)) continue;
      const double own = channels_[c].squares / given.latest.variance(channel) - count;
      const double own_variance = 2 * count + 2 * count * count / given.latest.samples(channel);
      if (own > kSure * std::sqrt(own_variance)) return false;
      beyond += own;
      variance += own_variance;
    }
    if (beyond > kSure * std::sqrt(variance)) return false;
    if (end_ns == until_ns) return true;
  }
}

// A pole where the residuals of the beginning show the strongest line; in the place of one that shows nowhere, if there
// is one. false: there is no room.
bool WholeHold::add_pole(const Given& given) noexcept {
  std::size_t at = 0;
  while (at < poles_.size() && (poles_[at].real() == 0 || fit_.certain(at))) ++at;
  if (at == most_poles_) return false;
  const double stretch_s = std::min(to_s(given.latest.t0_ns() - from_ns_), kSearched * given.period_s);
  const double grid = 0.5 * std::numbers::pi / stretch_s;
  const std::uint64_t first = given.history.first_at(from_ns_),
                      end = given.history.first_at(from_ns_ + to_ns(stretch_s));
  double strongest = 0.0, found = 0.0;
  for (std::size_t k = 1; k <= kLines; ++k) {
    const double line = grid * static_cast<double>(k);
    for (PerChannel& channel : channels_) channel.line = 0.0;
    for (std::uint64_t i = first; i < end; ++i) {
      const SampleHistory::Sample& s = given.history[i];
      if (fit_.usable(s.channel))
        channels_[static_cast<std::size_t>(s.channel)].line +=
            fit_.residual(s.channel, s.t_ns, s.value) * std::polar(1.0, line * to_s(s.t_ns - from_ns_));
    }
    double power = 0.0;
    for (std::size_t c = 0; c < channels_.size(); ++c)
      if (const int channel = static_cast<int>(c); fit_.usable(channel) && given.imposed[c] == 0)
        power += std::norm(channels_[c].line) / given.latest.variance(channel);
    if (power > strongest) strongest = power, found = line;
  }
  if (!(strongest > 0)) return false;
  const Complex pole{-1 / stretch_s, found};
  if (at < poles_.size())
    poles_[at] = pole;
  else
    poles_.push_back(pole);
  return true;
}

}  // namespace dwell
