#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr int kLargestSolved = 64;  // masses; beyond, the eigenvalues cost more than they tell

constexpr double kSoftest = 0.05, kLeastLoss = 0.005;  // stiffness and loss, of |Z|

}  // namespace

void Pipeline::Impl::settle(std::int64_t end_ns) {
  const int quarters = kQuarters * window.periods(), newest = blocks().count();
  for (int to = windows.first_end(at.steady_serial); to <= newest; ++to)
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
  for (int c = 0; c < channel_count; ++c) transient[static_cast<std::size_t>(c)] = windows.left(c);
  count_anew();
}

bool Pipeline::Impl::look(int from, int to) {
  const auto learn = [&](int c, double squares, double freedom) { return learn_noise(c, squares, freedom); };
  if (!windows.look(from, to, now_ns, learn)) return false;
  if (!modal_poles.empty()) return true;  // the modes tell more than windows do
  provisional();
  verdict = windows.judge(from, to, axis_s(blocks().block(to - 1).end_ns), time_constant_s);
  return true;
}

// The newest period counts an eighth of all. Windows are a quarter of a period apart and share three quarters.
double Pipeline::Impl::learn_noise(int c, double squares, double freedom) {
  Noise& noise = noises[static_cast<std::size_t>(c)];
  const double before = std::min(noise.freedom, 8 * freedom / kQuarters), now = freedom / kQuarters;
  if (before + now > 0) {
    noise.variance = ((before > 0 ? before * noise.variance : 0.0) + squares / kQuarters) / (before + now);
    noise.freedom = before + now;
  }
  return noise.freedom >= 4 ? noise.variance : INFINITY;
}

void Pipeline::Impl::provisional() {
  if (rig.mass_count() > kLargestSolved || !windows.wants_chain(at.steady_serial)) return;
  time_constant_s = kNaN;
  for (int c = 0; c < channel_count; ++c)
    if (windows.usable(c))
      usable_observation.observe(c, as_observed(rig, c, windows.phasor(c), omega(), 1));
    else
      usable_observation.leave_out(c);
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
