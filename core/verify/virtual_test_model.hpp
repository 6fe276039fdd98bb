// The chain and its transducers as one linear system in time, driven by what the table's transducer reads.
//
//   z' = M z ,   reading of channel c = h_c · z ,   z = (chain, integrals of u, filters, u, u', u'', u''')
//
// u is the table's reading between two of its samples: a cubic. Its derivatives are states of their own, so that one
// matrix exponential moves the whole test on, without a step-size error. The table's motion is what its transducer has
// made of it, undone:
//
//   y_0 = W(D) u ,   W(s) = 1 / (s^q H_low(s) H_high(s)) = Σ_j w_j s^j
//
// H_low = 1/P(s/ω_l) and H_high = 1/P(ω_h/s) with polynomials P, so W is a finite sum: derivatives of u for j > 0,
// repeated integrals for j < 0. q: 0 displacement, 1 velocity, 2 acceleration. Delays are not in M: whoever plays the
// test shifts the instants. Internal to the room: it pulls in Eigen.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/model/chain.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

class VirtualTestModel {
 public:
  static constexpr Eigen::Index kInput = 4;  // u, u', u'', u'''

  // table: index of the channel that shows the table's motion. The chain must have no fault(). Allocates.
  VirtualTestModel(const Rig& rig, const Chain& chain, int table);

  // Why the test cannot be played ("the low-pass of y0 is of order 4, …"); empty: it can.
  [[nodiscard]] const std::string& fault() const noexcept { return fault_; }
  // Of the chain, the integrals and the filters: what has an initial value.
  [[nodiscard]] Eigen::Index states() const noexcept { return states_; }
  // Of these the chain's own come first: 2n.
  [[nodiscard]] Eigen::Index chain_states() const noexcept { return chain_states_; }
  // Repeated integrals of the reading that the table's motion needs: 0 for a displacement without AC coupling.
  [[nodiscard]] int integrals() const noexcept { return integrals_; }
  // states() + kInput, square.
  [[nodiscard]] const Eigen::MatrixXd& matrix() const noexcept { return M_; }
  // Largest natural frequency or corner, rad/s: what a step is measured by.
  [[nodiscard]] double fastest() const noexcept { return fastest_; }
  // Whether the channel can be predicted: no auxiliary one, nor one that would need a fourth derivative of u.
  [[nodiscard]] bool predicts(int channel) const { return !rows_.row(channel).isZero(0.0); }
  // h_c; zero for a channel that cannot be predicted.
  [[nodiscard]] Eigen::VectorXd row(int channel) const { return rows_.row(channel).transpose(); }
  // By which a channel's reading lags the motion, its device's delay included, ns.
  [[nodiscard]] std::int64_t delay_ns(int channel) const { return delays_ns_[static_cast<std::size_t>(channel)]; }
  [[nodiscard]] int table() const noexcept { return table_; }

 private:
  void undo_transducer(const Channel& channel);
  void couple_chain(const Chain& chain);
  void observe(const Rig& rig, const Chain& chain, Eigen::Index first_filter_state);
  [[nodiscard]] Eigen::RowVectorXd place(int at, const Chain& chain) const;

  int table_;
  std::string fault_;
  Eigen::Index chain_states_ = 0, states_ = 0;
  int integrals_ = 0;
  double fastest_ = 0.0;
  Eigen::MatrixXd M_, rows_;
  Eigen::VectorXd scale_;       // chain state = scale ∘ [y ; y']
  Eigen::RowVectorXd table_y_;  // y_0 = table_y_ · z
  std::vector<std::int64_t> delays_ns_;
};

}  // namespace dwell
