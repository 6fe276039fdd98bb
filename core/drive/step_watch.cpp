#include "core/drive/step_watch.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

constexpr double kSureOfStep = 5.6;      // standard deviations: once in 5e7, and tested some times a second for days
constexpr double kBeyond = 1.5;          // tolerances
constexpr double kInDoubt = 3.0;         // standard deviations …
constexpr double kUnsureBy = 0.1;        // … and tolerances
constexpr double kClip = 4.0;            // standard deviations of a reading …
constexpr double kClipPart = 0.5;        // … or what makes it half of the shortest window's say: no outlier says more
constexpr double kForget = 1.0 / 64;     // of the excess, per period
constexpr double kExcess = 0.6;          // of the variance by noise, from which an excess shows
constexpr double kSureOfRounding = 3.0;  // standard deviations of what rounding does
constexpr int kSlips = 8;                // quarters of a period
constexpr int kQuartersAPeriod = 4, kNearQuarters = 32;  // quarters

}  // namespace

// Sums over the blocks since t_j, the moments of time about now so that they serve every j.
struct StepWatch::Since {
  double late2 = 0, n = 0, rm = 0, mm = 0, q0 = 0, q1 = 0, q2 = 0, r0 = 0, r1 = 0;
  void take(const Block& block, double ago_s) noexcept {
    late2 += block.late2;
    n += block.n;
    rm += block.rm;
    mm += block.mm;
    r0 += block.rq;
    r1 += block.rq * ago_s;
    q0 += block.qq;
    q1 += block.qq * ago_s;
    q2 += block.qq * ago_s * ago_s;
  }
  // Σ r q τ and Σ q² τ², τ the time since t_j, which was since_s ago.
  [[nodiscard]] double score(double since_s) const noexcept { return since_s * r0 - r1; }
  [[nodiscard]] double weight(double since_s) const noexcept { return since_s * since_s * q0 - 2 * since_s * q1 + q2; }
};

void StepWatch::restart() noexcept {
  seen_ = 0;
  referred_ = false;
  open_ = {};
  open_t_ = in_quarter_ = excess_ = tolerated_ = late_s_ = 0.0;
  since_good_ = in_doubt_ = slipping_ = 0;
  far_amplitude_doubt_ = far_drift_doubt_ = false;
}

void StepWatch::refer(const Reference& reference) noexcept {
  if (referred_) {
    const double shift_s = 1e-9 * static_cast<double>(reference.t_ref_ns - now_.t_ref_ns);
    const double before = std::abs(now_.X[0]), after = std::abs(reference.X[0]);
    const double advance = (now_.omega + 0.5 * now_.drift * shift_s) * shift_s;
    const double turned = std::arg(reference.X[0] * std::conj(now_.X[0] * std::polar(1.0, advance)));
    const double faster = reference.omega - now_.omega - now_.drift * shift_s;
    const double more_drift = reference.drift - now_.drift;
    const auto to_reference = [&](Block& block) {
      block.t_s -= shift_s;
      const double dphi = turned + (faster + 0.5 * more_drift * block.t_s) * block.t_s;
      const double scale = after / before;
      block.rm = (block.rm - (scale - 1) * block.mm) * scale;
      block.rq = (block.rq - dphi * block.qq) * scale;
      block.mm *= scale * scale;
      block.qq *= scale * scale;
    };
    const std::int64_t held = std::min<std::int64_t>(seen_, kLongest);
    for (std::int64_t i = seen_ - held; i < seen_; ++i) to_reference(blocks_[static_cast<std::size_t>(i % kLongest)]);
    open_ = {};
    open_t_ = 0.0;
  }
  now_ = reference;
  referred_ = true;
}

void StepWatch::add(std::int64_t t_ns, double value, double late_s) noexcept {
  if (!referred_) return;
  const double t_s = 1e-9 * static_cast<double>(t_ns - now_.t_ref_ns);
  const std::complex<double> step =
      std::polar(1.0, std::remainder((now_.omega + 0.5 * now_.drift * t_s) * t_s, kTwoPi));
  std::complex<double> turn = step;
  double predicted = now_.mean;
  for (int h = 0; h < now_.harmonics; ++h, turn *= step)
    predicted += (now_.X[static_cast<std::size_t>(h)] * turn).imag();  // p sin + q cos = Im (p + jq) exp(jωt)
  const std::complex<double> now = now_.X[0] * step;
  const double most =
      std::max(kClip * now_.sigma, kClipPart * kShortest * in_quarter_ * tolerance_ * std::abs(now_.X[0]));
  const double r = std::clamp(value - predicted, -most, most);
  open_.rm += r * now.imag();
  open_.mm += now.imag() * now.imag();
  open_.rq += r * now.real();
  open_.qq += now.real() * now.real();
  open_.late2 += late_s * late_s;
  open_.n += 1.0;
  open_t_ += t_s;
}

bool StepWatch::close() noexcept {
  if (!referred_ || open_.n == 0) return false;
  open_.t_s = open_t_ / open_.n;
  in_quarter_ += ((seen_ == 0 ? open_.n : std::min(open_.n, 2 * in_quarter_)) - in_quarter_) / (seen_ < 8 ? 2 : 8);
  blocks_[static_cast<std::size_t>(seen_ % kLongest)] = open_;
  ++seen_;
  open_ = {};
  open_t_ = 0.0;
  const int most = static_cast<int>(std::min<std::int64_t>(seen_, kLongest));
  const double quarter_s = kTwoPi / now_.omega / kQuartersAPeriod, sigma2 = now_.sigma * now_.sigma;
  Since sums;
  double worst = 0;
  const double now_s = back(0).t_s + quarter_s / 2;
  bool by_amplitude_doubt = false, by_drift_doubt = false;
  // What takes long to show may be looked for once a period.
  const bool far = seen_ % kQuartersAPeriod == 0;
  if (far) far_amplitude_doubt_ = far_drift_doubt_ = false;
  for (int k = 0; k < (far ? most : std::min(most, kNearQuarters)); ++k) {
    const double ago = now_s - back(k).t_s;
    sums.take(back(k), ago);
    if (k + 1 == kQuartersAPeriod) late_s_ = std::sqrt(sums.late2 / sums.n);
    // Beyond some periods not every length is needed: those of like length see the same.
    if (k + 1 < kQuartersAPeriod || (k > kNearQuarters && (k & (k >> 5 > 1 ? 7 : 3)) != 3) ||
        !(sums.mm > 0 && sums.q0 > 0))
      continue;
    const double since = ago + quarter_s / 2, weight = sums.weight(since);
    const double alpha = sums.rm / sums.mm, drift = sums.score(since) / weight;
    const double late2 = now_.omega * now_.omega * sums.late2 / sums.n;  // rad²
    const double u2_alpha = sigma2 / sums.mm + now_.u_amplitude * now_.u_amplitude;
    // The reference's phase at t_j is as uncertain as it is; a constant offset looks like a slope of 3/2 of it.
    const double u_then = now_.u_omega * (now_s - since),
                 u2_phase = now_.u_phase * now_.u_phase + u_then * u_then + late2;
    const double u2_drift = sigma2 / weight + 2.25 * u2_phase / (since * since) + now_.u_omega * now_.u_omega;
    // Most often neither is in doubt, let alone beyond.
    if (alpha * alpha > kInDoubt * kInDoubt * u2_alpha || drift * drift > kInDoubt * kInDoubt * u2_drift) {
      const double u_alpha = std::sqrt(u2_alpha), u_drift = std::sqrt(u2_drift), by_phase = tolerated_ / since;
      const bool amplitude = std::abs(alpha) > kInDoubt * u_alpha + kUnsureBy * tolerance_ + tolerated_,
                 phase = std::abs(drift) > kInDoubt * u_drift + kUnsureBy * tolerance_ * now_.omega + by_phase;
      by_amplitude_doubt = by_amplitude_doubt || amplitude;
      by_drift_doubt = by_drift_doubt || phase;
      if (k >= kNearQuarters) {
        far_amplitude_doubt_ = far_amplitude_doubt_ || amplitude;
        far_drift_doubt_ = far_drift_doubt_ || phase;
      }
      const double by_amplitude =
          std::abs(alpha) / (std::max((kBeyond + beats_) * tolerance_, kSureOfStep * u_alpha) + tolerated_ + late2);
      const double by_drift =
          std::abs(drift) / (std::max(kBeyond * tolerance_ * now_.omega, kSureOfStep * u_drift) + by_phase);
      if (k + 1 >= kShortest) worst = std::max({worst, by_amplitude, by_drift});
    }
    if (k + 1 == kQuartersAPeriod && in_doubt_ == 0) {
      excess_ += kForget / kQuartersAPeriod *
                 (std::min(alpha * alpha, 9 * u2_alpha + tolerance_ * tolerance_) - u2_alpha - excess_);
      const double shown = std::clamp(excess_ - kExcess * u2_alpha, 0.0, tolerance_ * tolerance_ / 2);
      tolerated_ = kBeyond * std::sqrt(shown) + kSureOfRounding * now_.u_rounding;
    }
  }
  if (!far) {
    by_amplitude_doubt = by_amplitude_doubt || far_amplitude_doubt_;
    by_drift_doubt = by_drift_doubt || far_drift_doubt_;
  }
  in_doubt_ = by_amplitude_doubt ? in_doubt_ + 1 : 0;
  slipping_ = by_drift_doubt ? slipping_ + 1 : 0;
  // Another frequency is seen within two periods; a phase that slips for longer is a drive that drifts.
  const int doubtful = std::max(in_doubt_, slipping_ <= kSlips ? slipping_ : 0);
  since_good_ = worst > 1 ? changed() : std::min(doubtful, kShortest);
  return worst > 1;
}

// How many quarter periods ago the drive changed: where a change explains most.
int StepWatch::changed() const noexcept {
  const int most = static_cast<int>(std::min<std::int64_t>(seen_, kLongest));
  const double quarter_s = kTwoPi / now_.omega / kQuartersAPeriod, now_s = back(0).t_s + quarter_s / 2;
  Since sums;
  double most_explained = 0;
  int changed = 0;
  for (int k = 0; k < most; ++k) {
    const double ago = now_s - back(k).t_s, since = ago + quarter_s / 2;
    sums.take(back(k), ago);
    const double score = sums.score(since);
    const double explains = sums.rm * sums.rm / sums.mm + score * score / sums.weight(since);  // NaN: there is nothing
    if (!(explains > most_explained)) continue;
    most_explained = explains;
    changed = k + 1;
  }
  // A ramp explains most a little after it has begun.
  const auto alone = [&](double r, double p) {
    return p > 0 && std::abs(r / p) > kInDoubt * now_.sigma / std::sqrt(p) + kUnsureBy * tolerance_ + tolerated_;
  };
  for (int more = 0; more < kQuartersAPeriod && changed < most; ++more, ++changed) {
    const Block& before = back(changed);
    if (!alone(before.rm, before.mm) && !alone(before.rq, before.qq)) break;
  }
  return changed;
}

}  // namespace dwell
