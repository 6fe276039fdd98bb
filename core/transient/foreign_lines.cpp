#include "core/transient/foreign_lines.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/complex.hpp"
#include "core/transient/fit_limits.hpp"

namespace dwell {
namespace {

constexpr std::size_t kMains = 8, kLines = 400;  // lines searched: of hum at 50 and 60 Hz; of the grid, at most
// Searched: so many periods from the begin of the fit, up to this multiple of the drive's ω.
constexpr double kSearchPeriods = 10.0;
constexpr double kSureOfLine = 9.0;       // noise alone exceeds it by exp(-9): once in 8000 searches
constexpr double kFewestReadings = 16.0;  // readings of a channel, at least
// The power of a mains line counts this many times that of a line of the grid.
constexpr double kMainsFirst = 1.2;
constexpr double kBeside = 2.0;  // half cycles over the search: a line nearer to a harmonic is taken for it
// Away from the mains and the harmonics a line is steady after kLongSeen periods if its decay rate + 3 u, times the
// time seen, is below kHardlyDecayed. kMainsWander: relative, of the mains' frequency.
constexpr double kLongSeen = 60.0, kHardlyDecayed = 0.3, kMainsWander = 0.004;
// A line is taken as steady unless decaying lowers N ln σ², a χ²(1), by more than this.
constexpr double kSpeaksAgainst = 6.0;
constexpr double kHarmonicOff = 1e-4;     // a line is at a harmonic of the drive within this relative distance …
constexpr double kHarmonicUnsure = 0.02;  // … where its frequency is known to this part of the drive's

// ω of line k of mains hum, rad/s: the fundamental and first harmonics of either kind.
double mains(std::size_t k) {
  return kTwoPi * kMainsFundamentals_hz[k / (kMains / 2)] * static_cast<double>(k % (kMains / 2) + 1);
}

// Sums r exp(jkθ), k = 1, 2 …, over samples; four samples at once, so that none waits for the turn of another.
class LineSums {
 public:
  // θ = grid · u; grid in rad/s.
  LineSums(double grid, std::span<Complex> sums) : grid_(grid), sums_(sums) {}

  // Adds the residual r at u, s.
  void add(double r, double u) noexcept {
    const Complex step = std::polar(1.0, grid_ * u);
    step_re_[count_] = step.real(), step_im_[count_] = step.imag();
    re_[count_] = r * step.real(), im_[count_] = r * step.imag();
    if (++count_ == kTogether) complete();
  }
  // Call before the sums are read.
  void complete() noexcept {
    for (; count_ < kTogether; ++count_) step_re_[count_] = step_im_[count_] = re_[count_] = im_[count_] = 0.0;
    for (Complex& sum : sums_) {
      double re = sum.real(), im = sum.imag();
      for (std::size_t i = 0; i < kTogether; ++i) re += re_[i], im += im_[i];
      sum = {re, im};
      for (std::size_t i = 0; i < kTogether; ++i) {
        const double turned = re_[i] * step_re_[i] - im_[i] * step_im_[i];
        im_[i] = re_[i] * step_im_[i] + im_[i] * step_re_[i];
        re_[i] = turned;
      }
    }
    count_ = 0;
  }

 private:
  static constexpr std::size_t kTogether = 4;
  using Each = std::array<double, kTogether>;

  double grid_;
  std::span<Complex> sums_;
  Each re_{}, im_{}, step_re_{}, step_im_{};  // r exp(jkθ), exp(jθ)
  std::size_t count_ = 0;
};

}  // namespace

ForeignLines::ForeignLines(PoleSearch& search, HoldFit& fit, ResidualNoise& noise, std::size_t masses)
    : search_(search), fit_(fit), noise_(noise), spectrum_(kMains + kLines) {
  before_.reserve(4 * masses + 4);
}

bool ForeignLines::find(const HoldNow& now) {
  std::vector<Complex>& beside = search_.poles().beside;
  if (beside.size() >= kMost) return false;
  const double stretch_s = std::min(to_s(now.now_ns - fit_.fit().t0_ns()), kSearchPeriods * now.period_s());
  const double found = strongest_line(stretch_s, now);
  if (found == 0) return false;
  beside.emplace_back(-1 / stretch_s, found);
  return true;
}

double ForeignLines::strongest_line(double stretch_s, const HoldNow& now) noexcept {
  ModalFit& fit = fit_.fit();
  const SampleHistory& history = fit_.history();
  const std::int64_t until_ns = fit.t0_ns() + to_ns(stretch_s);
  const double grid = std::numbers::pi / stretch_s, seen_s = std::max(1e-9, to_s(now.now_ns - fit.t0_ns()));
  // As the channel is sampled, a mains line may alias to the mean.
  const auto is_mean = [&](int c, double line) {
    const double apart_hz = kBeside / (2 * seen_s);
    return now.channel(c).sampling.distance_hz(line / kTwoPi, 0.0) < apart_hz;
  };
  double strongest = 0.0, found = 0.0;
  for (int c = 0; c < fit_.channels(); ++c) {
    if (!fit.usable(c)) continue;
    const double rate = fit.samples(c) / seen_s;
    const auto lines = static_cast<std::size_t>(
        std::clamp(std::min(std::numbers::pi * 0.9 * rate, kHighestSearched * now.omega) / grid, 0.0,
                   static_cast<double>(spectrum_.size() - kMains)));
    std::fill(spectrum_.begin(), spectrum_.end(), Complex{});
    double squares = 0.0, count = 0.0;
    const std::span all(spectrum_);
    std::array sums{LineSums(mains(0), all.first(kMains / 2)),
                    LineSums(mains(kMains / 2), all.subspan(kMains / 2, kMains / 2)),
                    LineSums(grid, all.subspan(kMains, lines))};
    for (auto i = history.first_at(fit.t0_ns()); i < history.end() && history[i].t_ns < until_ns; ++i) {
      const SampleHistory::Sample& s = history[i];
      history.spend(s.channel == c ? kOfLine * static_cast<double>(kMains + lines) : 1.0);
      if (s.channel != c || s.held_up) continue;
      const double r = fit.residual(c, s.t_ns, s.value), u = to_s(s.t_ns - fit.t0_ns());
      for (LineSums& each : sums) each.add(r, u);
      squares += r * r;
      count += 1.0;
    }
    for (LineSums& each : sums) each.complete();
    if (count < kFewestReadings || !(squares > 0)) continue;
    // For white noise, P exceeds x with probability exp(-x).
    const double sure = std::log(static_cast<double>(lines) + 1) + kSureOfLine;
    for (std::size_t k = 0; k < (now.channel(c).imposed ? kMains : kMains + lines); ++k) {
      // A mains line and its alias tie in the periodogram: prefer the mains.
      const double P = std::norm(spectrum_[k]) / squares * (k < kMains ? kMainsFirst : 1.0);
      if (P - sure <= strongest) continue;
      // A line beside a fitted harmonic tells that the drive's own frequency is a little off.
      const double line = k < kMains ? mains(k) : grid * static_cast<double>(k - kMains + 1);
      if (std::abs(std::remainder(line, now.omega)) < kBeside * grid && line < (fit_.harmonics() + 0.5) * now.omega)
        continue;
      if (k < kMains && is_mean(c, line)) continue;
      strongest = P - sure;
      found = line;
    }
  }
  return found;
}

bool ForeignLines::near_mains(Complex pole, double u) const noexcept {
  for (std::size_t k = 0; k < kMains; ++k)
    if (std::abs(pole.imag() - mains(k)) < kMainsWander * mains(k) + 3 * u) return true;
  return false;
}

// Whether the pole is at a harmonic of the drive above those that are fitted. u: of the pole, rad/s.
bool ForeignLines::near_harmonic(Complex pole, double u) const noexcept {
  const double w = fit_.fit().omega();
  const double times = std::round(pole.imag() / w), wide = 3 * u;
  return times > fit_.harmonics() && std::abs(pole.imag() - times * w) < wide + kHarmonicOff * pole.imag() &&
         wide < kHarmonicUnsure * w;
}

void ForeignLines::judge(const HoldNow& now) {
  std::vector<Complex>& beside = search_.poles().beside;
  const double seen_s = to_s(now.now_ns - fit_.fit().t0_ns());
  for (std::size_t i = 0; i < beside.size(); ++i) {
    fit_.fit().step_poles(PoleSearch::kTrust, 0.0);  // updates the poles' uncertainties
    const Complex pole = beside[i];
    const double u = fit_.fit().u_pole(i);
    const bool may_be_steady = near_mains(pole, u) || near_harmonic(pole, u);
    if (may_be_steady && fit_.may_fit())
      try_other_kind(i, seen_s, now);
    else if (!may_be_steady && pole.real() != 0 && seen_s > kLongSeen * now.period_s() &&
             (-pole.real() + 3 * u) * seen_s < kHardlyDecayed)
      beside[i].real(0.0);
  }
}

// Tries pole i beside the chain as a steady line if it decays, else as a mode that decays. The data decide.
void ForeignLines::try_other_kind(std::size_t i, double seen_s, const HoldNow& now) {
  std::vector<Complex>& best = search_.best();
  before_ = best;
  const double w = fit_.fit().omega(), given = fit_.fit().misfit();
  const bool was_steady = search_.poles().beside[i].real() == 0;
  best[i].real(was_steady ? -1 / seen_s : 0.0);
  const double other = search_.refine(search_.fit_best(w, now), PoleSearch::kManySteps, now);
  if (was_steady ? other + kSpeaksAgainst < given : other < given + kSpeaksAgainst) {
    search_.take_best();
  } else {
    best = before_;
    search_.fit_best(w, now);
    noise_.compare_halves(fit_, now.now_ns);
  }
}

}  // namespace dwell
