// What the modal fit leaves over: is it noise, or is there an oscillation that the chain does not have?
#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr double kSearchPeriods = 10.0, kSearchHarmonics = 12.0;  // where a pole beside the chain's is looked for
constexpr double kSureOfLine = 9.0;                               // exp(-9): once in 8000 searches noise alone
constexpr double kMainsFirst = 1.2;                               // of the power of any other line
constexpr double kBeside = 2.0;                                   // half cycles over the search
constexpr double kLongSeen = 60.0, kHardlyDecayed = 0.3, kMainsWander = 0.004;  // relative, of the mains' frequency
constexpr double kSpeaksAgainst = 6.0;                                          // in N ln σ², of χ²(1)
constexpr double kHarmonicOff = 1e-4;     // relative, of a line to a harmonic of the drive …
constexpr double kHarmonicUnsure = 0.02;  // … known to so much of the drive's frequency
constexpr double kSureOfNoise = 4.0;

// Angular frequencies of mains hum and its first harmonics, of either kind.
double mains(std::size_t k) {
  return kTwoPi * kMainsFundamentals_hz[k / (kMains / 2)] * static_cast<double>(k % (kMains / 2) + 1);
}

}  // namespace

// Whether every channel's residuals are no more than its noise.
bool Pipeline::Impl::explained() const {
  for (int c = 0; c < channel_count; ++c)
    if (modal.usable(c) && !shows_drive(rig.channels[static_cast<std::size_t>(c)]) && unexplained(c) > 0) return false;
  return true;
}

double Pipeline::Impl::unexplained(int c) const {
  const Noise& noise = noises[static_cast<std::size_t>(c)];
  // Instants of refreshes that are known to ± so much make residuals of their own.
  const double by_refresh = std::norm(omega() * live[c].intake().refresh_half_s() * modal.phasor(c, 1)) / 6;
  const double by_noise = modal.variance(c) - by_refresh -
                          noise.variance * (1 + kSureOfNoise * std::sqrt(2 / std::max(1.0, noise.freedom)));
  const double by_decay =
      noise.earlier - noise.later * (1 + kSureOfNoise * std::sqrt(2 / std::max(1.0, noise.in_earlier) +
                                                                  2 / std::max(1.0, noise.in_later)));
  return std::max(by_noise, by_decay);
}

// What a wrong set of poles leaves over decays, noise does not: the residuals of the earlier half of the fit and of the
// later.
void Pipeline::Impl::compare_halves() {
  const std::int64_t middle_ns = modal.t0_ns() + (now_ns - modal.t0_ns()) / 2;
  for (Noise& noise : noises) noise.earlier = noise.later = noise.in_earlier = noise.in_later = 0.0;
  for (auto i = history.first_at(modal.t0_ns()); i < modal_next; ++i) {
    const SampleHistory::Sample& s = history[i];
    if (!modal.usable(s.channel)) continue;
    const double r = modal.residual(s.channel, s.t_ns, s.value);
    Noise& noise = noises[static_cast<std::size_t>(s.channel)];
    (s.t_ns < middle_ns ? noise.earlier : noise.later) += r * r;
    (s.t_ns < middle_ns ? noise.in_earlier : noise.in_later) += 1.0;
  }
  // Each half has half of the fit's parameters.
  const double half = 0.5 * static_cast<double>(modal.parameters());
  for (Noise& noise : noises) {
    noise.earlier /= std::max(1.0, noise.in_earlier - half);
    noise.later /= std::max(1.0, noise.in_later - half);
  }
}

// What the fit leaves over may hold an oscillation that the chain does not have: a bracket that rings, mains hum. The
// strongest line of the beginning of the fit, where it is strongest, on top of what noise shows now and then.
bool Pipeline::Impl::find_extra_pole() {
  if (extra_poles.size() >= kExtraPoles) return false;
  const double stretch_s = std::min(to_s(now_ns - modal.t0_ns()), kSearchPeriods * period_s());
  const std::int64_t until_ns = modal.t0_ns() + to_ns(stretch_s);
  const double grid = std::numbers::pi / stretch_s;
  // As it is sampled, a line of the mains may be no other than the mean.
  const auto is_mean = [&](int c, double line) {
    const double apart_hz = kBeside / (2 * std::max(1e-9, to_s(now_ns - modal.t0_ns())));
    return live[c].sampling().distance_hz(line / kTwoPi, 0.0) < apart_hz;
  };
  double strongest = 0.0, found = 0.0;
  for (int c = 0; c < channel_count; ++c) {
    if (!modal.usable(c)) continue;
    const bool imposed = shows_drive(rig.channels[static_cast<std::size_t>(c)]);
    const double rate = modal.samples(c) / std::max(1e-9, to_s(now_ns - modal.t0_ns()));
    const auto lines =
        static_cast<std::size_t>(std::clamp(std::min(std::numbers::pi * 0.9 * rate, kSearchHarmonics * omega()) / grid,
                                            0.0, static_cast<double>(spectrum.size() - kMains)));
    std::fill(spectrum.begin(), spectrum.end(), Complex{});
    double squares = 0.0, count = 0.0;
    for (auto i = history.first_at(modal.t0_ns()); i < history.end() && history[i].t_ns < until_ns; ++i) {
      const SampleHistory::Sample& s = history[i];
      if (s.channel != c) continue;
      const double r = modal.residual(c, s.t_ns, s.value), u = to_s(s.t_ns - modal.t0_ns());
      const Complex step = std::polar(1.0, grid * u);
      Complex turn = r * step;
      for (std::size_t k = kMains; k < kMains + lines; ++k, turn *= step) spectrum[k] += turn;
      for (std::size_t k = 0; k < kMains; ++k) spectrum[k] += r * std::polar(1.0, mains(k) * u);
      squares += r * r;
      count += 1.0;
    }
    if (count < 16 || !(squares > 0)) continue;
    // Of white noise each is distributed as exp(-P).
    const double sure = std::log(static_cast<double>(lines) + 1) + kSureOfLine;
    for (std::size_t k = 0; k < (imposed ? kMains : kMains + lines); ++k) {
      // The mains are believed first: what they do is seen at their aliases as well.
      const double P = std::norm(spectrum[k]) / squares * (k < kMains ? kMainsFirst : 1.0);
      if (P - sure <= strongest) continue;
      // Beside a harmonic it would be the drive's own frequency that is a little off.
      const double line = k < kMains ? mains(k) : grid * static_cast<double>(k - kMains + 1);
      if (std::abs(std::remainder(line, omega())) < kBeside * grid && line < (H + 0.5) * omega()) continue;
      if (k < kMains && is_mean(c, line)) continue;
      strongest = P - sure;
      found = line;
    }
  }
  if (found == 0) return false;
  extra_poles.emplace_back(-1 / stretch_s, found);
  return true;
}

// An oscillation that does not decay is no transient. At the mains' frequencies that is believed unless the data speak
// against it; at others after a long time.
void Pipeline::Impl::judge_extra_poles() {
  const double seen_s = to_s(now_ns - modal.t0_ns());
  if (extra_poles.empty()) return;
  for (std::size_t i = 0; i < extra_poles.size(); ++i) {
    static_cast<void>(modal.refined(kTrust, 0.0));  // for the poles' uncertainties, of this fit
    const Complex pole = extra_poles[i];
    const double w = modal.omega();
    bool of_mains = false;
    for (std::size_t k = 0; k < kMains; ++k)
      of_mains = of_mains || std::abs(pole.imag() - mains(k)) < kMainsWander * mains(k) + 3 * modal.u_pole(i);
    // Nor is a harmonic of the drive above those that are fitted.
    const double times = std::round(pole.imag() / w), wide = 3 * modal.u_pole(i);
    const bool of_drive = times > H && std::abs(pole.imag() - times * w) < wide + kHarmonicOff * pole.imag() &&
                          wide < kHarmonicUnsure * w;
    if ((of_mains || of_drive) && fits_left > 0) {
      kept_poles = best_poles;
      const double given = modal.misfit();
      const bool was_steady = pole.real() == 0;
      best_poles[i].real(was_steady ? -1 / seen_s : 0.0);
      const double other = refine_poles(fit_modes(w, best_poles), kManyRefinements);
      if (was_steady ? other + kSpeaksAgainst < given : other < given + kSpeaksAgainst) {
        take_best_poles();
      } else {
        best_poles = kept_poles;
        fit_modes(w, best_poles);
        compare_halves();
      }
    } else if (!of_mains && !of_drive && pole.real() != 0 && seen_s > kLongSeen * period_s() &&
               (-pole.real() + 3 * modal.u_pole(i)) * seen_s < kHardlyDecayed) {
      extra_poles[i].real(0.0);
    }
  }
}

bool Pipeline::Impl::hums() const {
  return std::any_of(extra_poles.begin(), extra_poles.end(), [](Complex pole) { return pole.real() == 0; });
}

}  // namespace dwell
