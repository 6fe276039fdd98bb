#include "core/fit/moving_errors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/instants.hpp"
#include "core/base/neighbour_weights.hpp"

namespace dwell {
namespace {

using Complex = std::complex<double>;

// Readings of a period, at least. The cubic leaves 2/3 (1 - cos 2π/n)² of a sine read n times a period. Of an amplitude
// that swings by 1 % that is 4e-5 at n = 16, and 6e-4, as much as noise, at n = 8.
constexpr double kFewestInPeriod = 16.0;
// Readings with neighbours, at least, so that the sum of x is normal.
constexpr int kFewestJudged = 200;
// Largest variance of Σ x over Σ x²: see the header.
constexpr double kCorrelated = 2.71;
// Largest Σ w²: beyond it neighbours are so near each other that the cubic is bent by their noise.
constexpr double kMostBent = 4.0;

void fill_residuals(std::span<MovingReading> readings, const MovingContext& context) noexcept {
  const Complex own = context.fit.X[0] / std::abs(context.fit.X[0]);
  int harmonics = kMaxHarmonics;
  while (harmonics > 1 && context.fit.X[static_cast<std::size_t>(harmonics - 1)] == Complex{}) --harmonics;
  for (MovingReading& reading : readings) {
    const Complex turn = std::polar(1.0, context.omega * to_s(reading.t_ns - context.t_ref_ns)), at = turn * own;
    Complex power = turn;
    double motion = context.fit.mean;
    for (int h = 0; h < harmonics; ++h, power *= turn)
      motion += (context.fit.X[static_cast<std::size_t>(h)] * power).imag();
    reading.sine = at.imag();
    reading.cosine = at.real();
    reading.residual = reading.value - motion;
  }
}

using Harmonics = std::array<Complex, kMaxHarmonics>;

// Takes from the residuals what repeats with the motion, up to `harmonics`, and returns it: amplitudes and phases about
// ψ, as those of sines. Over many periods the harmonics are nearly orthogonal, so a second pass removes what the first
// has mixed.
Harmonics take_out_harmonics(std::span<MovingReading> readings, int harmonics) noexcept {
  Harmonics taken{};
  const double scale = 2.0 / static_cast<double>(readings.size());
  for (int pass = 0; pass < 2; ++pass) {
    Harmonics sums{};
    for (const MovingReading& reading : readings) {
      const Complex turn{reading.cosine, -reading.sine};
      Complex power = turn;
      for (int h = 0; h < harmonics; ++h, power *= turn) sums[static_cast<std::size_t>(h)] += reading.residual * power;
    }
    for (MovingReading& reading : readings) {
      const Complex turn{reading.cosine, reading.sine};
      Complex power = turn;
      for (int h = 0; h < harmonics; ++h, power *= turn)
        reading.residual -= scale * (sums[static_cast<std::size_t>(h)] * power).real();
    }
    for (std::size_t h = 0; h < taken.size(); ++h) taken[h] += Complex{0.0, scale} * sums[h];
  }
  return taken;
}

// Bound of m by harmonics beyond those taken out. Friction makes a force jump, so its harmonics fall as 1/h. Those from
// the ninth on then have together 4.5 times the mean square of harmonics 5 … 8; twice that is allowed, since single
// harmonics may be weak. At half the sampling rate s is 8/3 of a harmonic, which is 3.7 times as much as of noise in
// square.
double by_higher_harmonics(const HarmonicFit& fit, const Harmonics& taken, int harmonics) noexcept {
  constexpr int kFirst = 5;
  const Complex own = std::conj(fit.X[0]) / std::abs(fit.X[0]);
  double squares = 0.0;
  for (int h = kFirst; h <= harmonics; ++h) {
    const auto at = static_cast<std::size_t>(h - 1);
    squares += std::norm(fit.X[at] * std::pow(own, h) + taken[at]);
  }
  constexpr double kBeyond = 8.0, kKept = 4.0;
  return harmonics < kFirst ? 0.0 : 0.5 * kBeyond * kKept * squares / (harmonics - kFirst + 1);
}

double cos_twice_between(const MovingReading& a, const MovingReading& b) noexcept {
  const double between = a.cosine * b.cosine + a.sine * b.sine;
  return 2 * between * between - 1;
}

// Where a neighbour is missing, or the five lie too unevenly, s is NaN.
void fill_sharpness(std::span<MovingReading> readings, double interval_s) noexcept {
  constexpr std::size_t kBeside = 2;
  const double farthest_s = 3 * interval_s;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    MovingReading& reading = readings[i];
    reading.sharpness = kNaN;
    if (i < kBeside || i + kBeside >= readings.size()) continue;
    const MovingReading* const five = &readings[i - kBeside];
    std::array<double, 2 * kBeside + 1> t{}, weights{};
    for (std::size_t k = 0; k < t.size(); ++k) t[k] = to_s(five[k].t_ns - reading.t_ns);
    if (-t.front() > farthest_s || t.back() > farthest_s) continue;
    neighbour_weights(t.data(), kBeside, weights.data());
    double s = 0.0;
    reading.kept = reading.kappa = 0.0;
    for (std::size_t k = 0; k < t.size(); ++k) {
      s -= weights[k] * five[k].residual;
      reading.kept += weights[k] * weights[k];
      reading.kappa += weights[k] * weights[k] * cos_twice_between(reading, five[k]);
    }
    if (reading.kept < kMostBent) reading.sharpness = s;
  }
}

// What all readings together show of x.
struct MovingSums {
  double mean = 0.0, u = 0.0;  // of x, and standard uncertainty
  double kappa = 0.0;          // mean
  double count = 0.0;
};

MovingSums sums_of(std::span<const MovingReading> readings) noexcept {
  MovingSums out;
  double squares = 0.0;
  for (const MovingReading& reading : readings) {
    if (!std::isfinite(reading.sharpness)) continue;
    out.count += 1.0;
    squares += reading.sharpness * reading.sharpness;
    out.kappa += reading.kappa;
  }
  double sum = 0.0, sum2 = 0.0;
  for (const MovingReading& reading : readings) {
    if (!std::isfinite(reading.sharpness)) continue;
    const double cos_2psi = reading.cosine * reading.cosine - reading.sine * reading.sine;
    const double x = -(reading.sharpness * reading.sharpness - squares / out.count) * cos_2psi;
    sum += x;
    sum2 += x * x;
  }
  if (!(out.count > 0)) return out;
  out.kappa /= out.count;
  out.mean = sum / out.count;
  out.u = std::sqrt(kCorrelated * std::max(0.0, sum2 / out.count - out.mean * out.mean) / out.count);
  return out;
}

}  // namespace

MovingErrors moving_errors(std::span<MovingReading> readings, const MovingContext& context) noexcept {
  const double amplitude = std::abs(context.fit.X[0]), in_period = kTwoPi / (context.omega * context.interval_s);
  if (!context.fit.usable || !(amplitude > 0) || !(in_period >= kFewestInPeriod)) return {};
  if (static_cast<double>(readings.size()) < std::max<double>(kFewestJudged, 2 * in_period)) return {};
  fill_residuals(readings, context);
  const int harmonics = std::min(kMaxHarmonics, static_cast<int>(in_period / 2) - 1);
  const double higher = by_higher_harmonics(context.fit, take_out_harmonics(readings, harmonics), harmonics);
  fill_sharpness(readings, context.interval_s);
  const MovingSums x = sums_of(readings);
  if (x.count < kFewestJudged || !(x.kappa > 0)) return {};
  const double square = 2 * std::abs(x.mean) / x.kappa, u_square = 2 * x.u / x.kappa;  // m
  // Rounding errs less at the turning points. It repeats with the motion where a period has a whole number of readings,
  // so that its square does not average out: no more than that of half a step.
  const double by_rounding = context.rounding * context.rounding / 4;
  if (!(square - by_rounding - higher > sigmas::kSure * u_square)) return {};
  if (x.mean > 0) return {.part = std::sqrt(2 * square) / amplitude};
  const double to_s2 = 2 / (context.omega * context.omega * amplitude * amplitude);
  return {.instants_s = std::sqrt(square * to_s2), .instants_u2 = u_square * to_s2};
}

bool share_instants(const MovingChannel& a, const MovingChannel& b, double omega) noexcept {
  double products = 0.0, squares = 0.0, weights = 0.0;
  for (std::size_t i = 0, j = 0; i < a.readings.size() && j < b.readings.size();) {
    const MovingReading &one = a.readings[i], &other = b.readings[j];
    if (one.t_ns != other.t_ns) {
      ++(one.t_ns < other.t_ns ? i : j);
      continue;
    }
    ++i;
    ++j;
    if (!std::isfinite(one.sharpness * other.sharpness)) continue;
    // Errors τ in common leave E s_a s_b = ω² |X_a| |X_b| E τ² Σ w_k² cos ψ_a cos ψ_b.
    const double cosines = one.cosine * other.cosine, sines = one.sine * other.sine;
    const double expected = 0.5 * (one.kept * (cosines + sines) + one.kappa * (cosines - sines));
    const double product = one.sharpness * other.sharpness * expected;
    products += product;
    squares += product * product;
    weights += expected * expected;
  }
  const double per_s2 = omega * omega * a.amplitude * b.amplitude * weights;
  const double common = products / per_s2, u = std::sqrt(kCorrelated * squares) / per_s2;
  const auto explains = [&](const MovingErrors& errors) {
    if (errors.instants_s == 0.0) return true;
    return std::abs(errors.instants_s * errors.instants_s - common) <
           sigmas::kNoise * std::hypot(errors.instants_u2, u);
  };
  return common > sigmas::kShown * u && explains(a.errors) && explains(b.errors);
}

}  // namespace dwell
