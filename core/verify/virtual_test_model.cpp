#include "core/verify/virtual_test_model.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/model/state_matrix.hpp"
#include "core/motion/filter_sections.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::RowVectorXd;

// u''' is the last derivative that a cubic has, and the dampers need one more than the table's motion.
constexpr int kMostDerivatives = 2;

}  // namespace

VirtualTestModel::VirtualTestModel(const Rig& rig, const Chain& chain, int table) : table_(table) {
  const Channel& shows = rig.channels[static_cast<std::size_t>(table)];
  chain_states_ = 2 * chain.mass_count();
  integrals_ = derivative_order(shows.measures) + state_count(shows.highpass);
  const Index first_filter_state = chain_states_ + integrals_;
  states_ = first_filter_state;
  for (const Channel& channel : rig.channels)
    if (channel.measures != Quantity::auxiliary)
      states_ += state_count(channel.lowpass) + state_count(channel.highpass);
  M_ = Eigen::MatrixXd::Zero(states_ + kInput, states_ + kInput);
  for (Index j = 0; j + 1 < kInput; ++j) M_(states_ + j, states_ + j + 1) = 1.0;
  for (int j = 0; j < integrals_; ++j) M_(chain_states_ + j, j == 0 ? states_ : chain_states_ + j - 1) = 1.0;
  undo_transducer(shows);
  couple_chain(chain);
  observe(rig, chain, first_filter_state);
}

void VirtualTestModel::undo_transducer(const Channel& channel) {
  const std::vector<double> low = filter_polynomial(channel.lowpass), high = filter_polynomial(channel.highpass);
  const int q = derivative_order(channel.measures);
  table_y_ = RowVectorXd::Zero(M_.rows());
  for (std::size_t i = 0; i < low.size(); ++i)
    for (std::size_t j = 0; j < high.size(); ++j) {
      const int power = static_cast<int>(i) - static_cast<int>(j) - q;
      if (power > kMostDerivatives) {
        fault_ =
            "the low-pass of " + channel.name + " is of order " + std::to_string(channel.lowpass.order) +
            ": at most order " + std::to_string(kMostDerivatives + q) +
            " can be undone between its samples; expected a transducer of the table with a low-pass of lower order";
        return;
      }
      const double w = low[i] * high[j] * std::pow(kTwoPi * channel.lowpass.hz, -static_cast<double>(i)) *
                       std::pow(kTwoPi * channel.highpass.hz, static_cast<double>(j));
      table_y_(power >= 0 ? states_ + power : chain_states_ - power - 1) += w;
    }
}

void VirtualTestModel::couple_chain(const Chain& chain) {
  const Index n = chain.mass_count();
  if (n == 0) return;
  const StateMatrix state = state_matrix(chain);
  scale_ = state.scale;
  M_.topLeftCorner(2 * n, 2 * n) = state.A;
  fastest_ = state.A.cwiseAbs().rowwise().sum().maxCoeff();
  const RowVectorXd table_velocity = table_y_ * M_;
  M_.row(n) += (chain.stiffness[0] * table_y_ + chain.damping[0] * table_velocity) / std::sqrt(chain.masses[0]);
}

RowVectorXd VirtualTestModel::place(int at, const Chain& chain) const {
  RowVectorXd row = RowVectorXd::Zero(M_.rows());
  if (at == 0) row = table_y_;
  if (at > 0 && at <= chain.mass_count()) row(at - 1) = 1.0 / scale_(at - 1);
  return row;
}

void VirtualTestModel::observe(const Rig& rig, const Chain& chain, Index first_filter_state) {
  rows_ = Eigen::MatrixXd::Zero(static_cast<Index>(rig.channels.size()), M_.rows());
  Index state = first_filter_state;
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    const Channel& channel = rig.channels[c];
    delays_ns_.push_back(to_ns(channel.delay_s + device_delay_s(rig, channel)));
    if (channel.measures == Quantity::auxiliary) continue;
    RowVectorXd row = place(channel.at, chain);
    if (channel.measures == Quantity::force) {
      row = RowVectorXd::Zero(M_.rows());
      if (chain.boundary == Boundary::clamped) {
        const RowVectorXd end = place(chain.mass_count(), chain), end_velocity = end * M_;
        row =
            (channel.force_on_mass ? -1.0 : 1.0) * (chain.stiffness.back() * end + chain.damping.back() * end_velocity);
      }
    } else if (channel.relative_to) {
      row -= place(*channel.relative_to, chain);
    }
    bool known = true;
    for (int q = derivative_order(channel.measures); q > 0; --q) {
      known = known && row(M_.cols() - 1) == 0.0;  // of u''' there is no derivative
      row = (row * M_).eval();
    }
    for (const bool high : {false, true}) {
      const Filter& filter = high ? channel.highpass : channel.lowpass;
      row = add_filter(filter, high, row, state, M_);
      state += state_count(filter);
      for (const FilterSection& section : filter_sections(filter, high)) fastest_ = std::max(fastest_, 3 * section.w);
    }
    if (known) rows_.row(static_cast<Index>(c)) = row;
  }
}

}  // namespace dwell
