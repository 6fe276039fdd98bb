#include "core/dwell/settling_windows.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

constexpr double kMoved = 0.2;      // tolerances: a larger change of ω takes the windows anew
constexpr double kInQuarter = 5.0;  // samples: a mean, a sine and a cosine, and two more for the noise

}  // namespace

SettlingWindows::SettlingWindows(const Rig& rig, LiveChannels& live, const CountedData& data)
    : rig_(rig),
      live_(live),
      data_(data),
      detector_(live.count(), rig.tolerance),
      fits_(static_cast<std::size_t>(live.count())),
      readings_(static_cast<std::size_t>(live.count())),
      left_(static_cast<std::size_t>(live.count())) {}

void SettlingWindows::begin_hold() noexcept {
  detector_.restart();
  omega_ = data_.omega();
  solve_at_serial_ = 0;
}

void SettlingWindows::keep_left() noexcept {
  for (int c = 0; c < live_.count(); ++c) left_[static_cast<std::size_t>(c)] = detector_.left(c);
}

int SettlingWindows::first_end(std::int64_t steady_serial) noexcept {
  const Blocks& blocks = data_.blocks();
  const bool moved = std::abs(data_.omega() / omega_ - 1) > kMoved * rig_.tolerance;
  if (!moved || blocks.serials() - steady_serial > Blocks::kFine) return blocks.count();
  detector_.restart();
  omega_ = data_.omega();
  const int quarters = kQuarters * length_.periods();
  return std::max(blocks.index_of(steady_serial) + quarters, quarters);
}

bool SettlingWindows::fit(int from, int to) noexcept {
  const std::int64_t begin_ns = data_.blocks().block(from).begin_ns, end_ns = data_.blocks().block(to - 1).end_ns;
  data_.fit_all(from, to, begin_ns + (end_ns - begin_ns) / 2, fits_);
  return table().usable;
}

double SettlingWindows::table_u() const noexcept {
  return std::sqrt(0.5 * table().covariance.trace()) / std::abs(table().X[0]);
}

bool SettlingWindows::is_watched(int c, std::int64_t now_ns) const noexcept {
  const double period_s = data_.period_s();
  return rig_.channels[static_cast<std::size_t>(c)].measures != Quantity::auxiliary &&
         live_[c].delivers(now_ns, period_s) && !live_[c].unfit(period_s, rig_.tolerance);
}

bool SettlingWindows::too_few_samples(int c) const noexcept {
  const HarmonicFit& fit = fits_[static_cast<std::size_t>(c)];
  return !fit.usable && length_.periods() == 1 && fit.samples >= 2 * rig_.excitation.harmonics + 1;
}

// A mean, a sine and a cosine follow any smooth motion over a quarter of a period, or a half where a quarter has too
// few samples. Their residuals are noise.
SettlingWindows::Noise SettlingWindows::noise_of(int c, int from, int to) const noexcept {
  const Blocks& blocks = data_.blocks();
  const double in_quarter = fits_[static_cast<std::size_t>(c)].samples / (to - from);
  const int length = in_quarter >= kInQuarter ? 1 : 2;
  Noise noise;
  for (int i = from; i + length <= to; i += length) {
    const HarmonicFit fit = data_.fit(c, i, i + length, blocks.block(i).omega, blocks.block(i).centre_ns, 1);
    if (!std::isfinite(fit.sigma2)) continue;
    noise.squares += fit.sigma2 * (fit.samples - 3);
    noise.freedom += fit.samples - 3;
  }
  return noise;
}

void SettlingWindows::take(int c, bool watched, double noise_known) noexcept {
  const HarmonicFit& fit = fits_[static_cast<std::size_t>(c)];
  SettlingDetector::Reading& reading = readings_[static_cast<std::size_t>(c)];
  const std::complex<double> back = std::conj(table().X[0]) / std::abs(table().X[0]);
  const double noise = watched && fit.usable ? std::min(fit.sigma2, noise_known) : 0.0;
  const double u = std::sqrt(0.5 * fit.covariance.trace() * (fit.sigma2 > 0 ? noise / fit.sigma2 : 1.0));
  // Relative to the table's phase, whose own noise is added.
  reading = {fit.X[0] * back,      {}, std::hypot(u, std::abs(fit.X[0]) * table_u()), fit.sigma2, noise, fit.samples,
             watched && fit.usable};
  reading.others[0] = fit.mean;
  std::complex<double> turn = back;
  for (std::size_t h = 1; h < static_cast<std::size_t>(rig_.excitation.harmonics); ++h)
    reading.others[h] = fit.X[h] * (turn *= back);
}

std::complex<double> SettlingWindows::phasor(int c) const noexcept {
  const std::complex<double> seen = detector_.later_mean(c);
  return seen != 0.0 ? seen : readings_[static_cast<std::size_t>(c)].relative;
}

bool SettlingWindows::wants_chain(std::int64_t steady_serial) noexcept {
  const std::int64_t serials = data_.blocks().serials();
  if (serials < solve_at_serial_) return false;
  solve_at_serial_ = serials + std::max<std::int64_t>(1, (serials - steady_serial) / 32);
  return true;
}

SettlingDetector::Verdict SettlingWindows::judge(int from, int to, double t_s, double time_constant_s) noexcept {
  const Blocks& blocks = data_.blocks();
  const double amplitude = std::abs(table().X[0]);
  return detector_.update(blocks.block(from).first_serial, blocks.block(to - 1).first_serial, t_s, amplitude,
                          table_u() * amplitude, readings_, data_.period_s() * length_.periods(), time_constant_s);
}

}  // namespace dwell
