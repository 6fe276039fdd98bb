#include "core/drive/step_watch.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/fit/blocks.hpp"
#include "core/fit/moments.hpp"
#include "core/rig/rig.hpp"

namespace dwell {
namespace {

constexpr double kSureOfStep =
    5.6;  // standard deviations: chance 1 in 5e7 a test, some tests a second (study: docs/method.md, 5)
constexpr double kBeyond = 1.5;  // tolerances that a step must exceed too
// A residual is clipped, so that one disturbed reading does not look like a step. Over the shortest stretch a step by
// one tolerance adds up to a certain sum of residuals; a single reading counts at most kClipPart of that sum. The clip
// is never below sigmas::kShown standard deviations of a reading.
constexpr double kClipPart = 0.5;
// rad: largest phase since an earlier reading at which a reading's turn follows from that one's by a polynomial
// (moments::sin_cos, exact below π/4 = 0.785). Smaller: libm is called more often.
constexpr double kNear = 0.78;
constexpr int kNearQuarters = 32;  // stretches up to kNearQuarters are tested at every look

}  // namespace

void StepWatch::restart() noexcept {
  blocks_.restart();
  excess_.restart();
  doubt_.restart();
  referred_ = false;
  extra_u_s_ = 0.0;
  since_good_ = 0;
}

void StepWatch::refer(const Reference& reference) noexcept {
  if (referred_) {
    const double shift_s = 1e-9 * static_cast<double>(reference.t_ref_ns - now_.t_ref_ns);
    const double before = amplitude_, after = std::abs(reference.X[0]);
    const double advance = (now_.omega + 0.5 * now_.drift * shift_s) * shift_s;
    const double turned = std::arg(reference.X[0] * std::conj(now_.X[0] * std::polar(1.0, advance)));
    const double faster = reference.omega - now_.omega - now_.drift * shift_s;
    const double more_drift = reference.drift - now_.drift;
    for (int k = 0; k < blocks_.kept(); ++k) {
      ResidualBlock& block = blocks_.back(k);
      block.t_s -= shift_s;
      const double dphi = turned + (faster + 0.5 * more_drift * block.t_s) * block.t_s;
      const double scale = after / before;
      block.rm = (block.rm - (scale - 1) * block.mm) * scale;
      block.rq = (block.rq - dphi * block.qq) * scale;
      block.mm *= scale * scale;
      block.qq *= scale * scale;
    }
    blocks_.drop_open();
  }
  now_ = reference;
  amplitude_ = std::abs(now_.X[0]);
  near_ = {};
  referred_ = true;
}

// exp(jφ), φ = (ω + drift t/2) t. libm is called only a few times a period: its sine costs as much as all the rest of
// add(), and its last bits differ from machine to machine.
std::complex<double> StepWatch::turn_at(double t_s) noexcept {
  const double since_s = t_s - near_.t_s;
  const double angle = (now_.omega + now_.drift * (near_.t_s + 0.5 * since_s)) * since_s;
  if (!(std::abs(angle) < kNear)) {
    near_ = {t_s, std::polar(1.0, std::remainder((now_.omega + 0.5 * now_.drift * t_s) * t_s, kTwoPi))};
    return near_.turn;
  }
  double sine = 0.0, cosine = 0.0;
  moments::sin_cos(angle, sine, cosine);
  return near_.turn * std::complex<double>{cosine, sine};
}

void StepWatch::add(std::int64_t t_ns, double value, double extra_u_s) noexcept {
  if (!referred_) return;
  const double t_s = 1e-9 * static_cast<double>(t_ns - now_.t_ref_ns);
  const std::complex<double> step = turn_at(t_s);
  std::complex<double> turn = step;
  double predicted = now_.mean;
  for (int h = 0; h < now_.harmonics; ++h, turn *= step)
    predicted += (now_.X[static_cast<std::size_t>(h)] * turn).imag();  // p sin + q cos = Im (p + jq) exp(jωt)
  const std::complex<double> now = now_.X[0] * step;
  const double most =
      std::max(sigmas::kShown * now_.sigma, kClipPart * kShortest * blocks_.in_quarter() * tolerance_ * amplitude_);
  const double r = std::clamp(value - predicted, -most, most);
  blocks_.add(t_s, r, now, extra_u_s);
}

// Inline, like weigh(): a look calls both for every length.
inline StepWatch::Change StepWatch::change_since(const ResidualsSince& sums, double since_s,
                                                 double now_s) const noexcept {
  const double sigma2 = now_.sigma * now_.sigma, weight = sums.weight(since_s);
  const double extra_u2 = now_.omega * now_.omega * sums.extra_u2 / sums.n;
  // A constant phase error of the reference looks like 3/2 of it as a slope: variance 2.25 u2_phase / since_s².
  const double u_then = now_.u_omega * (now_s - since_s),
               u2_phase = now_.u_phase * now_.u_phase + u_then * u_then + extra_u2;
  return {.since_s = since_s,
          .alpha = sums.rm / sums.mm,
          .u2_alpha = sigma2 / sums.mm + now_.u_amplitude * now_.u_amplitude,
          .drift = sums.score(since_s) / weight,
          .u2_drift = sigma2 / weight + 2.25 * u2_phase / (since_s * since_s) + now_.u_omega * now_.u_omega,
          .extra_u2 = extra_u2};
}

// Notes whether the drive is in doubt. Returns the change in units of its limit: above 1 the drive has stepped.
inline double StepWatch::weigh(const Change& change, bool far_back) noexcept {
  const double alpha = std::abs(change.alpha), drift = std::abs(change.drift);
  // The usual case: neither is in doubt, so neither is beyond its limit.
  if (!(alpha * alpha > sigmas::kNoise * sigmas::kNoise * change.u2_alpha ||
        drift * drift > sigmas::kNoise * sigmas::kNoise * change.u2_drift))
    return 0.0;
  const double u_alpha = std::sqrt(change.u2_alpha), u_drift = std::sqrt(change.u2_drift);
  const double tolerated = excess_.tolerated(), by_phase = tolerated / change.since_s;
  doubt_.see(alpha > sigmas::kNoise * u_alpha + kToleranceShare * tolerance_ + tolerated,
             drift > sigmas::kNoise * u_drift + kToleranceShare * tolerance_ * now_.omega + by_phase, far_back);
  const double by_amplitude =
      alpha / (std::max((kBeyond + beats_) * tolerance_, kSureOfStep * u_alpha) + tolerated + change.extra_u2);
  const double by_drift = drift / (std::max(kBeyond * tolerance_ * now_.omega, kSureOfStep * u_drift) + by_phase);
  return std::max({0.0, by_amplitude, by_drift});
}

bool StepWatch::close() noexcept {
  if (!referred_ || !blocks_.close()) return false;
  const int most = blocks_.kept();
  const double quarter_s = kTwoPi / now_.omega / kQuarters, now_s = blocks_.back(0).t_s + quarter_s / 2;
  ResidualsSince sums;
  double worst = 0;
  // Changes that take long to show are looked for once a period.
  const bool far = blocks_.seen() % kQuarters == 0;
  doubt_.begin(far);
  for (int k = 0; k < (far ? most : std::min(most, kNearQuarters)); ++k) {
    const double ago = now_s - blocks_.back(k).t_s;
    sums.take(blocks_.back(k), ago);
    if (k + 1 == kQuarters) extra_u_s_ = std::sqrt(sums.extra_u2 / sums.n);
    // Beyond kNearQuarters not every length is tested: similar lengths show the same.
    if (k + 1 < kQuarters || (k > kNearQuarters && (k & (k >> 5 > 1 ? 7 : 3)) != 3) || !(sums.mm > 0 && sums.q0 > 0))
      continue;
    const Change change = change_since(sums, ago + quarter_s / 2, now_s);
    const double beyond = weigh(change, k >= kNearQuarters);
    if (k + 1 >= kShortest) worst = std::max(worst, beyond);
    if (k + 1 == kQuarters && doubt_.amplitude() == 0)
      excess_.take(change.alpha, change.u2_alpha, tolerance_, now_.u_rounding);
  }
  doubt_.end();
  since_good_ = worst > 1 ? changed() : std::min(doubt_.quarters(), kShortest);
  return worst > 1;
}

// How many quarter periods ago the drive changed: the instant at which a change explains most of the residuals.
int StepWatch::changed() const noexcept {
  const int most = blocks_.kept();
  const double quarter_s = kTwoPi / now_.omega / kQuarters, now_s = blocks_.back(0).t_s + quarter_s / 2;
  ResidualsSince sums;
  double most_explained = 0;
  int changed = 0;
  for (int k = 0; k < most; ++k) {
    const double ago = now_s - blocks_.back(k).t_s, since = ago + quarter_s / 2;
    sums.take(blocks_.back(k), ago);
    const double score = sums.score(since);
    const double explains = sums.rm * sums.rm / sums.mm + score * score / sums.weight(since);  // NaN: no data
    if (!(explains > most_explained)) continue;
    most_explained = explains;
    changed = k + 1;
  }
  // A ramp is dated a little late: quarters before that deviate by themselves belong to it.
  const auto alone = [&](double r, double p) {
    return p > 0 && std::abs(r / p) >
                        sigmas::kNoise * now_.sigma / std::sqrt(p) + kToleranceShare * tolerance_ + excess_.tolerated();
  };
  for (int more = 0; more < kQuarters && changed < most; ++more, ++changed) {
    const ResidualBlock& before = blocks_.back(changed);
    if (!alone(before.rm, before.mm) && !alone(before.rq, before.qq)) break;
  }
  return changed;
}

}  // namespace dwell
