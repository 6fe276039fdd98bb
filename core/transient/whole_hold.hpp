// Fits the natural oscillations over the whole of a hold, for the check of the model (docs/method.md, Cross-check).
//
// The fit that judges the transient leaves out the beginning of the hold, where modes that decay fast are visible. Once
// the steady motion and the noise are known, the same fit is made from ever earlier begins. Each begin starts from the
// poles of the one before. A mode that is hidden in noise keeps the pole of the identified chain: fitting it would
// follow the noise. The residuals of the beginning are compared with the noise. Where they exceed it, a pole is added
// at their strongest line (a bracket that rings; a mode far from where the chain has it). Where that does not help
// either, the fits end.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/stream/sample_history.hpp"
#include "core/transient/modal_fit.hpp"

namespace dwell {

class WholeHold {
 public:
  // modes: capacity in poles. stated: prior of ω. All memory is allocated here: that of a ModalFit, and 3 kB a channel.
  WholeHold(int channels, int harmonics, int modes, const FrequencyPrior& stated);

  struct Given {
    const SampleHistory& history;
    const ModalFit& latest;                       // the fit that judges the transient; its residuals are noise
    std::span<const std::complex<double>> chain;  // eigenvalues of the identified chain, rad/s
    std::span<const char> imposed;                // per channel: it shows the table, which has no transient
    std::int64_t begin_ns, until_ns;              // of the hold; history goes back to begin_ns
    double period_s;
    bool omega_known;
  };
  // Starts at the begin of `latest`, with its poles; allows the work of earlier() anew.
  void begin(const Given& given) noexcept;
  // Fits from an earlier begin. false: there are no earlier data, the fit does not explain them, or the work allowed
  // since begin() is spent: 0.3 s of a processor for 32 channels and 10 modes. No allocation.
  bool earlier(const Given& given) noexcept;
  // The fit of an earlier() that returned true, until the next call: last step made, errors of the poles propagated.
  [[nodiscard]] const ModalFit& fit() const noexcept { return fit_; }

 private:
  void take_poles(const Given& given, const ModalFit& fit) noexcept;
  double run(const Given& given, double omega, std::span<const std::complex<double>> poles) noexcept;
  void refine(const Given& given) noexcept;
  [[nodiscard]] bool explains(const Given& given) noexcept;
  [[nodiscard]] bool within_noise(const Given& given) const noexcept;
  [[nodiscard]] bool solved(const Given& given) const noexcept;
  bool add_pole(const Given& given) noexcept;

  struct PerChannel {
    double low = INFINITY, high = -INFINITY;  // of the readings
    double squares = 0.0, count = 0.0;        // of the residuals
    // Parts of the samples that are fitted: before and after the begin of the latest fit.
    double early_part = 1.0, late_part = 1.0;
    std::vector<std::complex<double>> lines;  // Fourier sums of the residuals
  };
  ModalFit fit_;
  std::size_t most_poles_;
  std::vector<std::complex<double>> poles_, trial_;
  std::vector<PerChannel> channels_;
  std::int64_t from_ns_ = 0, omega_at_ns_ = 0;
  double omega_ = 0.0;
  int passes_left_ = 0;
};

}  // namespace dwell
