#include "core/fit/moving_errors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/instants.hpp"

namespace dwell {
namespace {

// Readings of a period, at least. With fewer the curvature of a drive's swinging amplitude is no longer small, and a
// reading one period later may lie at another place of a harmonic that is not fitted.
constexpr double kFewestInPeriod = 12.0;
// Pairs of readings, at least: the normal approximation of the sum's distribution.
constexpr int kFewestPairs = 200;
// Of white errors, the variance of e over theirs; and the largest overlap of the sums: see the header.
constexpr double kKept = 3.0, kOverlap = 4.0;

void fill_residuals(std::span<MovingReading> readings, const MovingContext& context, int harmonics) noexcept {
  const std::complex<double> own = context.fit.X[0] / std::abs(context.fit.X[0]);
  for (MovingReading& reading : readings) {
    const double theta = context.omega * to_s(reading.t_ns - context.t_ref_ns);
    const std::complex<double> turn = std::polar(1.0, theta);
    std::complex<double> power = turn;
    double motion = context.fit.mean;
    for (int h = 0; h < harmonics; ++h, power *= turn)
      motion += (context.fit.X[static_cast<std::size_t>(h)] * power).imag();
    const std::complex<double> at = turn * own;
    reading.sine = at.imag();
    reading.cosine = at.real();
    reading.residual = reading.value - motion;
  }
}

// NaN at either end and where a neighbour is farther than `most_ns`.
void fill_curvatures(std::span<MovingReading> readings, std::int64_t most_ns) noexcept {
  for (std::size_t i = 0; i < readings.size(); ++i) {
    readings[i].curvature = kNaN;
    if (i == 0 || i + 1 == readings.size()) continue;
    const MovingReading &before = readings[i - 1], &after = readings[i + 1];
    const std::int64_t apart_ns = after.t_ns - before.t_ns;
    if (apart_ns <= 0 || apart_ns > most_ns) continue;
    const double of_before = static_cast<double>(after.t_ns - readings[i].t_ns) / static_cast<double>(apart_ns);
    readings[i].curvature = readings[i].residual - of_before * before.residual - (1 - of_before) * after.residual;
  }
}

// The reading one period later is the nearest to it, within nearest_ns.
void fill_changes(std::span<MovingReading> readings, std::int64_t period_ns, std::int64_t nearest_ns) noexcept {
  std::size_t j = 0;
  for (MovingReading& reading : readings) {
    reading.change = kNaN;
    const std::int64_t wanted = reading.t_ns + period_ns;
    while (j < readings.size() && readings[j].t_ns < wanted) ++j;
    if (j == readings.size()) continue;
    const std::size_t nearest = j > 0 && wanted - readings[j - 1].t_ns < readings[j].t_ns - wanted ? j - 1 : j;
    if (std::abs(readings[nearest].t_ns - wanted) <= nearest_ns)
      reading.change = readings[nearest].curvature - reading.curvature;
  }
}

double cos_2psi(const MovingReading& reading) noexcept {
  return reading.cosine * reading.cosine - reading.sine * reading.sine;
}

}  // namespace

MovingErrors moving_errors(std::span<MovingReading> readings, const MovingContext& context) noexcept {
  MovingErrors none;
  const double amplitude = std::abs(context.fit.X[0]), period_s = kTwoPi / context.omega;
  if (readings.size() < kFewestPairs || !context.fit.usable || !(amplitude > 0)) return none;
  const double span_s = to_s(readings.back().t_ns - readings.front().t_ns);
  const double in_period = static_cast<double>(readings.size()) * period_s / std::max(span_s, 1e-9);
  if (!(in_period >= kFewestInPeriod) || !(span_s > 2 * period_s)) return none;
  int harmonics = kMaxHarmonics;
  while (harmonics > 1 && context.fit.X[static_cast<std::size_t>(harmonics - 1)] == std::complex<double>{}) --harmonics;
  fill_residuals(readings, context, harmonics);
  const auto interval_ns = static_cast<std::int64_t>(1e9 * period_s / in_period);
  fill_curvatures(readings, 4 * interval_ns);
  fill_changes(readings, to_ns(period_s), interval_ns);
  double count = 0.0, squares = 0.0;
  for (const MovingReading& reading : readings) {
    if (!std::isfinite(reading.change)) continue;
    count += 1.0;
    squares += reading.change * reading.change;
  }
  if (count < kFewestPairs) return none;
  const double mean = squares / count;
  double sum = 0.0, sum2 = 0.0;
  for (const MovingReading& reading : readings) {
    if (!std::isfinite(reading.change)) continue;
    const double x = -(reading.change * reading.change - mean) * cos_2psi(reading);
    sum += x;
    sum2 += x * x;
  }
  const double x = sum / count, u = std::sqrt(kOverlap * std::max(0.0, sum2 / count - x * x) / count);
  const bool by_slope = x < 0;
  const double per_second = context.omega * amplitude;  // rms of the slope is this over √2
  const double known = by_slope ? 0.5 * std::pow(per_second * context.known_instants_s, 2) : 0.0;
  const double square = 2 * std::abs(x) / kKept, u_square = 2 * u / kKept;
  const double expected = known + context.rounding * context.rounding / 12;
  if (!(square - expected > sigmas::kSure * u_square)) return none;
  const double rms = std::sqrt(square - known), to_s2 = 2 / (per_second * per_second);
  if (by_slope) return {.instants_s = rms * std::sqrt(to_s2), .instants_u2 = u_square * to_s2};
  return {.part = rms * std::numbers::sqrt2 / amplitude};
}

bool share_instants(const MovingChannel& a, const MovingChannel& b, double omega) noexcept {
  double products = 0.0, squares = 0.0, weights = 0.0;
  for (std::size_t i = 0, j = 0; i < a.readings.size() && j < b.readings.size();) {
    const MovingReading &one = a.readings[i], &other = b.readings[j];
    if (one.t_ns != other.t_ns) {
      ++(one.t_ns < other.t_ns ? i : j);
      continue;
    }
    const double slopes = one.cosine * other.cosine, product = one.change * other.change * slopes;
    if (std::isfinite(product)) {
      products += product;
      squares += product * product;
      weights += slopes * slopes;
    }
    ++i;
    ++j;
  }
  const double per_s2 = kKept * omega * omega * a.amplitude * b.amplitude * weights;
  const double common = products / per_s2, u = std::sqrt(kOverlap * squares) / per_s2;
  const auto explains = [&](const MovingErrors& errors) {
    return errors.instants_s * errors.instants_s - common < sigmas::kNoise * std::hypot(errors.instants_u2, u);
  };
  return common > sigmas::kNoise * u && explains(a.errors) && explains(b.errors);
}

}  // namespace dwell
