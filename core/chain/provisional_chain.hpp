// Identifies the chain provisionally while the rig settles, for its natural oscillations and their slowest decay.
// Reported coefficients come from core/chain/estimate.hpp instead.
#pragma once

#include <Eigen/Core>
#include <complex>
#include <limits>
#include <span>
#include <vector>

#include "core/base/slices.hpp"
#include "core/model/chain_eigenvalues.hpp"
#include "core/rig/rig.hpp"
#include "core/rig/usable_observation.hpp"
#include "core/transient/chain_poles.hpp"

namespace dwell {

// Bound to one thread. Only the constructor allocates.
class ProvisionalChain final : public ChainPoles {
 public:
  // G: observation_matrix(rig). slices: counts the work done; may be null. rig and slices must outlive this object.
  ProvisionalChain(const Rig& rig, const Eigen::MatrixXd& G, Slices* slices = nullptr);

  // observe() gives the phasor X of channel c's reading at omega, rad/s; leave_out() marks a channel that does not
  // deliver. Call one of both for each channel before solve().
  void observe(int c, std::complex<double> X, double omega) noexcept;
  void leave_out(int c) noexcept { observation_.leave_out(c); }
  // Identifies the chain from these channels. false: they do not determine the chain, and the last one stays. O(n³).
  bool solve(double omega) noexcept;

  // Time constant of the slowest mode of the chain solved last, s; 0: no masses; infinite: a mode does not decay. NaN:
  // not known, none was solved.
  [[nodiscard]] double time_constant_s() const noexcept { return time_constant_s_; }
  void forget_time_constant() noexcept { time_constant_s_ = std::numeric_limits<double>::quiet_NaN(); }

  [[nodiscard]] std::span<const std::complex<double>> seen_by(const ModalFit& fit) noexcept override;
  // If noise or a transient make the chain look active: poles of the nearest lightly damped chain.
  [[nodiscard]] std::span<const std::complex<double>> last() const noexcept override { return eigenvalues_.values(); }

 private:
  void identify_chain(double omega) noexcept;
  double solve_decay(double omega) noexcept;

  const Rig& rig_;
  Slices* slices_;
  UsableObservation observation_;
  ChainEigenvalues eigenvalues_;
  Eigen::VectorXcd x_;                           // (Y_0, d_1 … d_n, F)
  std::vector<std::complex<double>> Y_, d_, Z_;  // as in core/chain/identify.hpp
  double time_constant_s_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace dwell
