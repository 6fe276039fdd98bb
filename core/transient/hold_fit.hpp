// The fit of natural oscillations (ModalFit) on the samples of one hold: which of the samples it has seen, from where
// on, and a second fit beside it in which other poles are tried.
#pragma once

#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/stream/sample_history.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/modal_fit.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor.
class HoldFit {
 public:
  // modes: at most so many poles. stated: of the drive's frequency. history must outlive this.
  HoldFit(const SampleHistory& history, int channels, int harmonics, int modes, const FrequencyPrior& stated);

  // The fit that is believed.
  [[nodiscard]] ModalFit& fit() noexcept { return believed_; }
  [[nodiscard]] const ModalFit& fit() const noexcept { return believed_; }
  [[nodiscard]] const SampleHistory& history() const noexcept { return history_; }
  [[nodiscard]] int channels() const noexcept { return static_cast<int>(ranges_.size()); }
  [[nodiscard]] int harmonics() const noexcept { return harmonics_; }

  // From where on the samples are fitted the next time.
  void begin_at(std::int64_t from_ns) noexcept { from_ns_ = from_ns; }
  [[nodiscard]] std::int64_t from_ns() const noexcept { return from_ns_; }
  // By which the drive's frequency drifts in the next fit, rad/s².
  void set_rate(double rate) noexcept { rate_ = rate; }
  [[nodiscard]] double rate() const noexcept { return rate_; }
  // How far each channel's readings go from its reference, from from_ns() on: the width of the amplitudes' prior.
  // O(samples).
  void measure_ranges(std::span<const FittedChannel> channels) noexcept;

  // Shows the fit the samples of watched channels that it has not seen.
  void feed(std::span<const FittedChannel> channels) noexcept;
  void solve(std::span<const FittedChannel> channels) noexcept;
  // The fit anew, with these poles (rad/s) and that ω at from_ns(); its misfit. O(samples), costs one of the fits
  // allowed.
  double anew(double omega, std::span<const std::complex<double>> poles,
              std::span<const FittedChannel> channels) noexcept;
  // The same, believed only where its misfit is below `misfit`, which it then replaces. Whether it is believed.
  bool attempt(double omega, std::span<const std::complex<double>> poles, std::span<const FittedChannel> channels,
               double& misfit) noexcept;

  // How many fits may still be made: what bounds the work of one refit.
  void allow(int fits) noexcept { fits_left_ = fits; }
  void allow_at_least(int fits) noexcept { fits_left_ = std::max(fits_left_, fits); }
  [[nodiscard]] bool may_fit() const noexcept { return fits_left_ > 0; }
  // How many fits with so many poles a refit may make. However long the hold, going over it again has its limit: what
  // was not tried is tried next time.
  [[nodiscard]] int affordable(std::size_t poles) const noexcept;

  // Whether every channel has clearly more readings than regressors: few are explained by any poles.
  [[nodiscard]] bool determined() const noexcept;
  // Decay rate of the slowest mode that is fitted, 1/s; infinity: none.
  [[nodiscard]] double slowest_rate() const noexcept;

  // Calls f(channel, t_ns, residual) for the samples that the fit has seen, from from_ns on.
  template <class F>
  void each_residual(std::int64_t from_ns, F&& f) noexcept {
    for (auto i = history_.first_at(from_ns); i < next_; ++i) {
      const SampleHistory::Sample& s = history_[i];
      if (believed_.usable(s.channel)) f(s.channel, s.t_ns, believed_.residual(s.channel, s.t_ns, s.value));
      history_.spend(believed_.work_of_residual());
    }
  }

 private:
  const SampleHistory& history_;
  int harmonics_;
  ModalFit believed_, spare_;
  std::uint64_t next_ = 0;  // the first sample of the history that the fit has not seen
  std::int64_t from_ns_ = 0;
  double rate_ = 0.0;
  std::vector<double> ranges_;  // per channel
  int fits_left_ = 0;
};

}  // namespace dwell
