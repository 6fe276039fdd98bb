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

// Angular frequencies of mains hum and its first harmonics, of either kind.
double mains(std::size_t k) {
  return kTwoPi * kMainsFundamentals_hz[k / (kMains / 2)] * static_cast<double>(k % (kMains / 2) + 1);
}

}  // namespace

// What the fit leaves over may hold an oscillation that the chain does not have: a bracket that rings, mains hum. The
// strongest line of the beginning of the fit, where it is strongest, on top of what noise shows now and then.
bool Pipeline::Impl::find_extra_pole() {
  if (extra_poles.size() >= kExtraPoles) return false;
  const double stretch_s = std::min(to_s(now_ns - hold_fit.fit().t0_ns()), kSearchPeriods * period_s());
  const std::int64_t until_ns = hold_fit.fit().t0_ns() + to_ns(stretch_s);
  const double grid = std::numbers::pi / stretch_s;
  // As it is sampled, a line of the mains may be no other than the mean.
  const auto is_mean = [&](int c, double line) {
    const double apart_hz = kBeside / (2 * std::max(1e-9, to_s(now_ns - hold_fit.fit().t0_ns())));
    return live[static_cast<std::size_t>(c)].sampling.distance_hz(line / kTwoPi, 0.0) < apart_hz;
  };
  double strongest = 0.0, found = 0.0;
  for (int c = 0; c < channel_count; ++c) {
    if (!hold_fit.fit().usable(c)) continue;
    const bool imposed = shows_drive(rig.channels[static_cast<std::size_t>(c)]);
    const double rate = hold_fit.fit().samples(c) / std::max(1e-9, to_s(now_ns - hold_fit.fit().t0_ns()));
    const auto lines =
        static_cast<std::size_t>(std::clamp(std::min(std::numbers::pi * 0.9 * rate, kSearchHarmonics * omega) / grid,
                                            0.0, static_cast<double>(spectrum.size() - kMains)));
    std::fill(spectrum.begin(), spectrum.end(), Complex{});
    double squares = 0.0, count = 0.0;
    for (auto i = history.first_at(hold_fit.fit().t0_ns()); i < history.end() && history[i].t_ns < until_ns; ++i) {
      const SampleHistory::Sample& s = history[i];
      if (s.channel != c) continue;
      const double r = hold_fit.fit().residual(c, s.t_ns, s.value), u = to_s(s.t_ns - hold_fit.fit().t0_ns());
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
      if (std::abs(std::remainder(line, omega)) < kBeside * grid && line < (H + 0.5) * omega) continue;
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
  const double seen_s = to_s(now_ns - hold_fit.fit().t0_ns());
  if (extra_poles.empty()) return;
  for (std::size_t i = 0; i < extra_poles.size(); ++i) {
    static_cast<void>(hold_fit.fit().refined(kTrust, 0.0));  // for the poles' uncertainties, of this fit
    const Complex pole = extra_poles[i];
    const double w = hold_fit.fit().omega();
    bool of_mains = false;
    for (std::size_t k = 0; k < kMains; ++k)
      of_mains = of_mains || std::abs(pole.imag() - mains(k)) < kMainsWander * mains(k) + 3 * hold_fit.fit().u_pole(i);
    // Nor is a harmonic of the drive above those that are fitted.
    const double times = std::round(pole.imag() / w), wide = 3 * hold_fit.fit().u_pole(i);
    const bool of_drive = times > H && std::abs(pole.imag() - times * w) < wide + kHarmonicOff * pole.imag() &&
                          wide < kHarmonicUnsure * w;
    if ((of_mains || of_drive) && hold_fit.may_fit()) {
      kept_poles = best_poles;
      const double given = hold_fit.fit().misfit();
      const bool was_steady = pole.real() == 0;
      best_poles[i].real(was_steady ? -1 / seen_s : 0.0);
      const double other = refine_poles(fit_modes(w, best_poles), kManyRefinements);
      if (was_steady ? other + kSpeaksAgainst < given : other < given + kSpeaksAgainst) {
        take_best_poles();
      } else {
        best_poles = kept_poles;
        fit_modes(w, best_poles);
        residual_noise.compare_halves(hold_fit, now_ns);
      }
    } else if (!of_mains && !of_drive && pole.real() != 0 && seen_s > kLongSeen * period_s() &&
               (-pole.real() + 3 * hold_fit.fit().u_pole(i)) * seen_s < kHardlyDecayed) {
      extra_poles[i].real(0.0);
    }
  }
}

bool Pipeline::Impl::hums() const {
  return std::any_of(extra_poles.begin(), extra_poles.end(), [](Complex pole) { return pole.real() == 0; });
}

}  // namespace dwell
