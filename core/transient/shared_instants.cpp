#include "core/transient/shared_instants.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/instants.hpp"

namespace dwell {
namespace {

// The speed is the difference quotient of two fitted readings. It lags by half their distance: at an eighth of a period
// the estimate of the drive's motion loses 5 %.
constexpr double kClose = 1.0 / 8;  // periods

}  // namespace

SharedInstants::SharedInstants(int channels)
    : transactions_(static_cast<std::size_t>(channels)), newest_(static_cast<std::size_t>(channels)) {}

// (Σ x)² - Σ x² is the sum over all pairs of different channels.
void SharedInstants::Transaction::end_instant() noexcept {
  products += za * za - za2;
  squares += a2 * a2 - a4;
  za = za2 = a2 = a4 = 0.0;
}

void SharedInstants::look(HoldFit& fit, const HoldNow& now) noexcept {
  for (Transaction& of : transactions_) of = {};
  for (Newest& of : newest_) of = {};
  const ModalFit& fitted = fit.fit();
  const std::int64_t close_ns = to_ns(kClose * now.period_s());
  fit.each_residual(fitted.t0_ns(), [&](const SampleHistory::Sample& sample, double residual) {
    const auto c = static_cast<std::size_t>(sample.channel);
    const Newest before = newest_[c];
    newest_[c] = {sample.t_ns, sample.value - residual};
    if (before.t_ns < sample.t_ns - close_ns || before.t_ns >= sample.t_ns || !(fitted.variance(sample.channel) > 0))
      return;
    const double speed = (newest_[c].fitted - before.fitted) / to_s(sample.t_ns - before.t_ns),
                 a2 = speed * speed / fitted.variance(sample.channel),
                 za = residual * speed / fitted.variance(sample.channel);
    Transaction& of = transactions_[static_cast<std::size_t>(now.channels[c].transaction)];
    if (sample.t_ns != of.t_ns) of.end_instant();
    of.t_ns = sample.t_ns;
    of.za += za, of.za2 += za * za, of.a2 += a2, of.a4 += a2 * a2;
  });
  for (Transaction& of : transactions_) of.end_instant();
}

double SharedInstants::u_s(int transaction) const noexcept {
  const Transaction& of = transactions_[static_cast<std::size_t>(transaction)];
  return of.squares > 0 ? std::sqrt(std::max(0.0, of.products / of.squares)) : 0.0;
}

}  // namespace dwell
