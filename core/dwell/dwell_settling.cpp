#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr int kLargestSolved = 64;  // masses; beyond, the eigenvalues cost more than they tell

}  // namespace

void Pipeline::Impl::settle(std::int64_t end_ns) {
  const int quarters = kQuarters * windows.length().periods(), newest = blocks().count();
  for (int to = windows.first_end(at.steady_serial); to <= newest; ++to)
    if (!look(to - quarters, to)) return;
  if (settle_by_modes(end_ns)) return;
  if (!verdict.settled || out_of_search()) return;
  // Without masses nothing rings, but the motion before may have been a ramp. A window tolerates a little of it: one
  // quarter more is dropped.
  const int counts_from = blocks().index_of(verdict.from_serial + (rig.mass_count() == 0 ? 1 : 0));
  if (counts_from >= blocks().count()) return;
  at.settled_ns = blocks().block(counts_from).begin_ns;
  data.forget_before(at.settled_ns);
  at.verdict_ns = end_ns;
  if (states.awaits_reason()) emit(EndedBy::drive_changed);
  states.begin_to_measure();
  live.begin_to_count();
  errors_in_motion.begin(at.settled_ns);
  windows.keep_left();
  resum();
}

bool Pipeline::Impl::look(int from, int to) {
  // Windows begin a quarter of a period apart and share three quarters: each residual is seen four times.
  const auto learn = [&](int c, double squares, double freedom) {
    modes.noise().learn(c, squares / kQuarters, freedom / kQuarters);
    return modes.noise().known(c) ? modes.noise().variance(c) : INFINITY;
  };
  if (!windows.look(from, to, now_ns, learn)) return false;
  if (modes.has_poles()) return true;  // poles tell more than windows do
  provisional();
  verdict = windows.judge(from, to, axis_s(blocks().block(to - 1).end_ns), provisional_chain.time_constant_s());
  return true;
}

void Pipeline::Impl::provisional() {
  if (rig.mass_count() > kLargestSolved || !windows.wants_chain(at.steady_serial)) return;
  provisional_chain.forget_time_constant();
  for (int c = 0; c < live.count(); ++c)
    if (windows.usable(c))
      provisional_chain.observe(c, windows.phasor(c), omega());
    else
      provisional_chain.leave_out(c);
  provisional_chain.solve(omega());
}

}  // namespace dwell
