// Feeds the samples of one hold to the fit of natural oscillations (ModalFit), and tries other poles in a second fit
// beside it. Keeps where the fit begins and which samples it has seen.
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
  // modes: capacity in poles. stated: prior of the drive's frequency. history must outlive this.
  HoldFit(const SampleHistory& history, int channels, int harmonics, int modes, const FrequencyPrior& stated);

  // The fit that is believed.
  [[nodiscard]] ModalFit& fit() noexcept { return believed_; }
  [[nodiscard]] const ModalFit& fit() const noexcept { return believed_; }
  [[nodiscard]] const SampleHistory& history() const noexcept { return history_; }
  [[nodiscard]] int channels() const noexcept { return static_cast<int>(ranges_.size()); }
  [[nodiscard]] int harmonics() const noexcept { return harmonics_; }

  // Where the next fit begins.
  void begin_at(std::int64_t from_ns) noexcept { from_ns_ = from_ns; }
  [[nodiscard]] std::int64_t from_ns() const noexcept { return from_ns_; }
  // Drift of the drive's frequency in the next fit, rad/s².
  void set_rate(double rate) noexcept { rate_ = rate; }
  [[nodiscard]] double rate() const noexcept { return rate_; }
  // Measures how far each channel's readings since from_ns() go from its reference. This is the width of its
  // amplitudes' prior. O(samples).
  void measure_ranges(std::span<const FittedChannel> channels) noexcept;

  // Adds to the fit the samples of watched channels that it has not seen. Answers that were held up are left out: all
  // channels of a transaction share the error of its instant, and where a mode is still large one such answer moves
  // pole and shape together by more than their uncertainty.
  void feed(std::span<const FittedChannel> channels) noexcept;
  void solve(std::span<const FittedChannel> channels) noexcept;
  // Fits anew from from_ns() on. omega: ω at from_ns(), poles: both in rad/s. Returns the misfit. Takes O(samples) and
  // one of the fits allowed.
  double anew(double omega, std::span<const std::complex<double>> poles,
              std::span<const FittedChannel> channels) noexcept;
  // As anew(), but believes the new fit only where its misfit is below `misfit`, which it then replaces. Returns
  // whether the new fit is believed.
  bool attempt(double omega, std::span<const std::complex<double>> poles, std::span<const FittedChannel> channels,
               double& misfit) noexcept;

  // Sets how many fits may still be made. This bounds the work of one refit.
  void allow(int fits) noexcept { fits_left_ = fits; }
  void allow_at_least(int fits) noexcept { fits_left_ = std::max(fits_left_, fits); }
  [[nodiscard]] bool may_fit() const noexcept { return fits_left_ > 0; }
  // How many fits with so many poles one refit may make: fewer in a long hold. The next refit tries what is left.
  [[nodiscard]] int affordable(std::size_t poles) const noexcept;

  // Whether every channel has clearly more readings than regressors. Fewer readings are explained by any poles.
  [[nodiscard]] bool determined() const noexcept;
  // Decay rate of the slowest mode that is fitted, 1/s; infinity: none.
  [[nodiscard]] double slowest_rate() const noexcept;

  // Calls f(sample, residual) for the samples of solved channels that are in the fit, from from_ns on.
  template <class F>
  void each_residual(std::int64_t from_ns, F&& f) noexcept {
    for (auto i = history_.first_at(from_ns); i < next_; ++i) {
      const SampleHistory::Sample& s = history_[i];
      if (believed_.usable(s.channel) && !s.held_up) f(s, believed_.residual(s.channel, s.t_ns, s.value));
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
