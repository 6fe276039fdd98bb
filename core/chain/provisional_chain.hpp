// The chain as it can be identified so far, while the rig settles: for its natural oscillations and for how long it
// remembers. Coefficients that are reported come from core/chain/estimate.hpp instead.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <limits>
#include <span>
#include <vector>

#include "core/base/slices.hpp"
#include "core/model/decay.hpp"
#include "core/rig/rig.hpp"
#include "core/rig/usable_observation.hpp"
#include "core/transient/chain_poles.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor.
class ProvisionalChain final : public ChainPoles {
 public:
  // G: observation_matrix(rig). slices: in which it works; null: in one. rig and slices must outlive this.
  ProvisionalChain(const Rig& rig, const Eigen::MatrixXd& G, Slices* slices = nullptr);

  // The phasor X of channel c's reading at omega, rad/s; or that the channel does not deliver. All channels are to be
  // told before solve().
  void observe(int c, std::complex<double> X, double omega) noexcept;
  void leave_out(int c) noexcept { observation_.leave_out(c); }
  // Identifies the chain from these. false: they do not determine it, and all stays as it was. O(n³).
  bool solve(double omega) noexcept;

  // Time constant of the slowest natural oscillation of the chain solved last, s. NaN: none is known, or the chain
  // would not decay.
  [[nodiscard]] double time_constant_s() const noexcept { return time_constant_s_; }
  void forget_time_constant() noexcept { time_constant_s_ = std::numeric_limits<double>::quiet_NaN(); }

  [[nodiscard]] std::span<const std::complex<double>> seen_by(const ModalFit& fit) noexcept override;
  // Where noise or a transient make the chain look active, of the nearest lightly damped one.
  [[nodiscard]] std::span<const std::complex<double>> last() const noexcept override { return decay_.poles(); }

 private:
  void identify_chain(double omega) noexcept;
  double solve_decay(double omega) noexcept;

  const Rig& rig_;
  Slices* slices_;
  UsableObservation observation_;
  DecayRate decay_;
  Eigen::VectorXcd x_;                           // (Y_0, d_1 … d_n, F)
  std::vector<std::complex<double>> Y_, d_, Z_;  // of core/chain/identify.hpp
  double time_constant_s_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace dwell
