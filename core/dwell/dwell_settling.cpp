#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr int kLargestSolved = 64;  // masses; beyond, the eigenvalues cost more than they tell

constexpr double kSoftest = 0.05, kLeastLoss = 0.005;  // stiffness and loss, of |Z|

}  // namespace

void Pipeline::Impl::settle(std::int64_t end_ns) {
  const int quarters = kQuarters * window.periods(), newest = blocks().count();
  int first = newest;
  if (std::abs(omega() / history_omega - 1) > 0.2 * rig.tolerance &&
      blocks().serials() - at.steady_serial <= Blocks::kFine) {
    settling.restart();
    history_omega = omega();
    first = std::max(blocks().index_of(at.steady_serial) + quarters, quarters);
  }
  for (int to = first; to <= newest; ++to)
    if (!look(to - quarters, to)) return;
  if (settle_by_modes(end_ns)) return;
  if (!verdict.settled || out_of_search()) return;
  // Where nothing rings the motion before may have been a ramp, of which a window bears a little.
  const int counts_from = blocks().index_of(verdict.from_serial + (rig.mass_count() == 0 ? 1 : 0));
  if (counts_from >= blocks().count()) return;
  at.settled_ns = blocks().block(counts_from).begin_ns;
  data.forget_before(at.settled_ns);
  at.verdict_ns = end_ns;
  states.begin_to_measure();
  live.begin_to_count();
  for (int c = 0; c < channel_count; ++c) transient[static_cast<std::size_t>(c)] = settling.left(c);
  count_anew();
}

bool Pipeline::Impl::look(int from, int to) {
  const std::int64_t begin_ns = blocks().block(from).begin_ns, end_ns = blocks().block(to - 1).end_ns;
  data.fit_all(from, to, begin_ns + (end_ns - begin_ns) / 2, fits);
  const HarmonicFit& table = fits[static_cast<std::size_t>(drive_channel())];
  if (!table.usable) return false;
  const Complex back = std::conj(table.X[0]) / std::abs(table.X[0]);
  const double u_table = std::sqrt(0.5 * table.covariance.trace()) / std::abs(table.X[0]);
  for (int c = 0; c < channel_count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const HarmonicFit& fit = fits[i];
    const bool watched =
        rig.channels[i].measures != Quantity::auxiliary && delivers(c) && !live[c].unfit(period_s(), rig.tolerance);
    if (watched && !fit.usable && window.periods() == 1 && fit.samples >= 2 * H + 1) {
      window.lengthen();
      return false;
    }
    if (watched && fit.usable) {
      take_noise(c, from, to);
      live[c].see_residuals(std::sqrt(fit.sigma2));
    }
    const double noise =
        watched && fit.usable ? std::min(fit.sigma2, noises[i].freedom >= 4 ? noises[i].variance : INFINITY) : 0.0;
    const double u = std::sqrt(0.5 * fit.covariance.trace() * (fit.sigma2 > 0 ? noise / fit.sigma2 : 1.0));
    // Relative to the table's phase, whose own noise comes on top.
    readings[i] = {fit.X[0] * back,      {},    std::hypot(u, std::abs(fit.X[0]) * u_table),
                   fit.sigma2,           noise, fit.samples,
                   watched && fit.usable};
    readings[i].others[0] = fit.mean;
    Complex turn = back;
    for (std::size_t h = 1; h < static_cast<std::size_t>(H); ++h) readings[i].others[h] = fit.X[h] * (turn *= back);
  }
  if (!modal_poles.empty()) return true;  // the modes tell more than windows do
  provisional();
  const double amplitude = std::abs(table.X[0]);
  verdict = settling.update(blocks().block(from).first_serial, blocks().block(to - 1).first_serial, axis_s(end_ns),
                            amplitude, u_table * amplitude, readings, period_s() * window.periods(), time_constant_s);
  return true;
}

// In stretches of a quarter of a period, or of a half where that has too few samples, a mean, a sine and a cosine
// follow any smooth motion; the newest period counts an eighth of all.
void Pipeline::Impl::take_noise(int c, int from, int to) {
  Noise& noise = noises[static_cast<std::size_t>(c)];
  const double in_quarter = fits[static_cast<std::size_t>(c)].samples / (to - from);
  const int length = in_quarter >= 5 ? 1 : 2;
  double squares = 0.0, freedom = 0.0;
  for (int i = from; i + length <= to; i += length) {
    const HarmonicFit fit = data.fit(c, i, i + length, blocks().block(i).omega, blocks().block(i).centre_ns, 1);
    if (!std::isfinite(fit.sigma2)) continue;
    squares += fit.sigma2 * (fit.samples - 3);
    freedom += fit.samples - 3;
  }
  // Windows are a quarter of a period apart and share three quarters.
  const double before = std::min(noise.freedom, 8 * freedom / kQuarters), now = freedom / kQuarters;
  if (!(before + now > 0)) return;
  noise.variance = ((before > 0 ? before * noise.variance : 0.0) + squares / kQuarters) / (before + now);
  noise.freedom = before + now;
}

void Pipeline::Impl::provisional() {
  if (rig.mass_count() > kLargestSolved || blocks().serials() < solve_at_serial) return;
  solve_at_serial = blocks().serials() + std::max<std::int64_t>(1, (blocks().serials() - at.steady_serial) / 32);
  time_constant_s = kNaN;
  for (int c = 0; c < channel_count; ++c) {
    const auto i = static_cast<std::size_t>(c);
    const Complex seen = settling.later_mean(c);
    if (readings[i].usable)
      usable_observation.observe(c, as_observed(rig, c, seen != 0.0 ? seen : readings[i].relative, omega(), 1));
    else
      usable_observation.leave_out(c);
  }
  if (usable_observation.solve(state_x)) time_constant_s = identified_time_constant(omega());
}

// From the chain's state in `state_x`.
double Pipeline::Impl::identified_time_constant(double w) {
  const int n = rig.mass_count();
  Y[0] = state_x(0);
  for (int k = 1; k <= n; ++k) {
    d[static_cast<std::size_t>(k - 1)] = state_x(k);
    Y[static_cast<std::size_t>(k)] = Y[static_cast<std::size_t>(k - 1)] + state_x(k);
  }
  identify(rig.boundary, rig.masses, w, Y, d, state_x(n + 1), Z);
  const double as_it_is_s = decay.time_constant_s(Z, w);
  // A real chain is passive; where noise or a transient make it look otherwise, it is taken as lightly damped.
  bool passive = true;
  for (Complex& z : Z) {
    const Complex nearest{std::max(z.real(), kSoftest * std::abs(z)), std::max(z.imag(), kLeastLoss * std::abs(z))};
    passive = passive && nearest == z;
    z = nearest;
  }
  if (!passive) static_cast<void>(decay.time_constant_s(Z, w));
  return as_it_is_s;
}

}  // namespace dwell
