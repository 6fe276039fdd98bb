#include "core/motion/motion_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/angle.hpp"
#include "core/motion/filter_sections.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::VectorXd;

// Terms of the series of e^(-δ A), behind the 1. With three, a delay of a quarter of a radian has an error of 2e-4 of
// the motion. With one, a rig without masses takes half of a delay for damping: the first-order all-pass
// (1 + jωδ/2)/(1 - jωδ/2) has the amplitude 1, as the delay has.
constexpr std::size_t kDelayTerms = 3;

bool differentiated_table(const Rig& rig) {
  return std::any_of(rig.channels.begin(), rig.channels.end(), [](const Channel& c) {
    return c.measures == Quantity::acceleration && (c.at == 0 || c.relative_to == 0);
  });
}

}  // namespace

MotionModel::MotionModel(const Rig& rig, std::vector<Parameter> parameters, TableProcess process)
    : rig_(rig),
      parameters_(std::move(parameters)),
      process_(process),
      apart_(apart(rig.mass_count())),
      omega0_(kTwoPi * (rig.excitation.frequency_hz > 0 ? rig.excitation.frequency_hz : 1.0)),
      n_(rig.mass_count()),
      table_(process == TableProcess::swelling ? 5
             : differentiated_table(rig)       ? 4
                                               : 3),
      states_(table_ + 2 * n_) {
  for (const Channel& channel : rig_.channels) {
    filters_at_.push_back(states_);
    if (channel.measures != Quantity::auxiliary)
      states_ += state_count(channel.lowpass) + state_count(channel.highpass);
  }
}

double MotionModel::delay_s(int c) const {
  const Channel& channel = rig_.channels[static_cast<std::size_t>(c)];
  return channel.delay_s + device_delay_s(rig_, channel);
}

RowVectorXd MotionModel::deformation_row(int k) const {
  RowVectorXd row = RowVectorXd::Zero(states_);
  if (k <= n_) {
    row(table_ + k - 1) = 1.0;
  } else {  // it ends at the ground
    row(0) = -1.0;
    row.segment(table_, n_).setConstant(-1.0);
  }
  return row;
}

RowVectorXd MotionModel::rate_row(int k) const {
  RowVectorXd row = RowVectorXd::Zero(states_);
  if (k <= n_) {
    row(table_ + n_ + k - 1) = omega0_;
  } else {
    row(1) = -omega0_;
    row.segment(table_ + n_, n_).setConstant(-omega0_);
  }
  return row;
}

RowVectorXd MotionModel::velocity_row(int k) const { return place_row({}, Quantity::velocity, k); }

RowVectorXd MotionModel::force_row(const Coefficients& of, int k) const {
  if (k > of.stiffness.size()) return RowVectorXd::Zero(states_);
  return of.stiffness(k - 1) * deformation_row(k) + of.damping(k - 1) * rate_row(k);
}

RowVectorXd MotionModel::side_row(const Coefficients& of, int k) const {
  RowVectorXd row = RowVectorXd::Zero(states_);
  for (std::size_t i = 0; i < apart_.size(); ++i) {
    const auto [a, b] = apart_[i];
    const double stiffness = of.side_stiffness(static_cast<Eigen::Index>(i));
    if (stiffness == 0.0 || (k != a && k != b)) continue;
    row += (k == a ? stiffness : -stiffness) *
           (place_row(of, Quantity::displacement, b) - place_row(of, Quantity::displacement, a));
  }
  return row;
}

RowVectorXd MotionModel::acceleration_row(const Coefficients& of, int k) const {
  if (k > 0)
    return of.inverse_mass(k - 1) * (force_row(of, k + 1) - force_row(of, k) + side_row(of, k) -
                                     of.ground_stiffness(k - 1) * place_row(of, Quantity::displacement, k) -
                                     of.ground_damping(k - 1) * place_row(of, Quantity::velocity, k));
  RowVectorXd row = RowVectorXd::Zero(states_);
  row(2) = omega0_ * omega0_;
  return row;
}

RowVectorXd MotionModel::place_row(const Coefficients& of, Quantity quantity, int place) const {
  RowVectorXd row = RowVectorXd::Zero(states_);
  if (place == kGround) return row;
  if (quantity == Quantity::acceleration) return acceleration_row(of, place);
  const bool velocity = quantity == Quantity::velocity;
  row(velocity ? 1 : 0) = velocity ? omega0_ : 1.0;
  row.segment(velocity ? table_ + n_ : table_, place).setConstant(velocity ? omega0_ : 1.0);
  return row;
}

RowVectorXd MotionModel::channel_row(const Coefficients& of, const Channel& channel, Of what) const {
  RowVectorXd row = RowVectorXd::Zero(states_);
  if (channel.measures == Quantity::force && what != Of::change_of_masses)
    return (channel.force_on_mass ? 1.0 : -1.0) * force_row(of, rig_.element_count());
  if (channel.measures == Quantity::force || channel.measures == Quantity::auxiliary) return row;
  const auto depends = [&](int place) {
    return what == Of::all || (channel.measures == Quantity::acceleration && place > 0);
  };
  if (depends(channel.at)) row += place_row(of, channel.measures, channel.at);
  if (channel.relative_to && depends(*channel.relative_to))
    row -= place_row(of, channel.measures, *channel.relative_to);
  return row;
}

void MotionModel::add_process(double drive, bool derivative, MatrixXd& A) const {
  const double r = 1 + drive;
  const double square = derivative ? 2 * r : r * r, fourth = derivative ? 4 * r * r * r : r * r * r * r;
  if (process_ == TableProcess::wandering) {
    A(table_ - 1, table_ - 2) = -omega0_ * square;
  } else {
    A(3, 2) = -2 * omega0_ * square;
    A(3, 0) = -omega0_ * fourth;
    A(3, 4) = omega0_ * fourth;
  }
}

MotionModel::Parts MotionModel::parts(const Coefficients& of, Of what) const {
  Parts out{MatrixXd::Zero(states_, states_), MatrixXd::Zero(static_cast<Eigen::Index>(rig_.channels.size()), states_)};
  const bool all = what == Of::all;
  for (int i = 0; i < noise_state() && all; ++i) out.A(i, i + 1) = omega0_;
  if (all) add_process(of.drive, false, out.A);
  RowVectorXd before = RowVectorXd::Zero(states_);  // acceleration of the table, then of the mass before
  if (all) before = acceleration_row(of, 0);
  for (int k = 1; k <= n_; ++k) {
    if (all) out.A(table_ + k - 1, table_ + n_ + k - 1) = omega0_;
    const RowVectorXd here = acceleration_row(of, k);
    out.A.row(table_ + n_ + k - 1) = (here - before) / omega0_;
    before = here;
  }
  for (std::size_t c = 0; c < rig_.channels.size(); ++c)
    out.C.row(static_cast<Eigen::Index>(c)) = channel_row(of, rig_.channels[c], what);
  add_filters(out, !all);
  return out;
}

void MotionModel::add_filters(Parts& to, bool change) const {
  for (std::size_t c = 0; c < rig_.channels.size(); ++c) {
    const Channel& channel = rig_.channels[c];
    if (channel.measures == Quantity::auxiliary) continue;
    const Eigen::Index first = filters_at_[c];
    RowVectorXd u = to.C.row(static_cast<Eigen::Index>(c));
    u = add_filter(channel.lowpass, false, u, first, to.A, change);
    u = add_filter(channel.highpass, true, u, first + state_count(channel.lowpass), to.A, change);
    to.C.row(static_cast<Eigen::Index>(c)) = u;
  }
}

MotionModel::Parts MotionModel::corner_derivative(const Parts& at, int c, bool high) const {
  Parts out{MatrixXd::Zero(states_, states_), MatrixXd::Zero(at.C.rows(), states_)};
  const Channel& channel = rig_.channels[static_cast<std::size_t>(c)];
  const int low_states = state_count(channel.lowpass);
  const int from = filters_at_[static_cast<std::size_t>(c)] + (high ? low_states : 0);
  const Filter& filter = high ? channel.highpass : channel.lowpass;
  out.A.middleRows(from, filter.order) = at.A.middleRows(from, filter.order) / filter.hz;
  return out;
}

MotionModel::Parts MotionModel::derivative(const Parameter& by, const Coefficients& at, const Parts& here) const {
  Coefficients change = at;
  const auto coefficient = [&change](Unknown what) -> VectorXd* {
    return what == Unknown::stiffness          ? &change.stiffness
           : what == Unknown::damping          ? &change.damping
           : what == Unknown::ground_stiffness ? &change.ground_stiffness
           : what == Unknown::ground_damping   ? &change.ground_damping
           : what == Unknown::side_stiffness   ? &change.side_stiffness
                                               : nullptr;
  };
  if (VectorXd* const of = coefficient(by.what); of != nullptr) {
    for (const Unknown what : {Unknown::stiffness, Unknown::damping, Unknown::ground_stiffness, Unknown::ground_damping,
                               Unknown::side_stiffness})
      coefficient(what)->setZero();
    (*of)(by.index) = 1.0;
    return parts(change, Of::change_of_elements);
  }
  if (by.what == Unknown::mass) {
    change.inverse_mass.setZero();
    change.inverse_mass(by.index) = -at.inverse_mass(by.index) * at.inverse_mass(by.index);
    return parts(change, Of::change_of_masses);
  }
  if (by.what == Unknown::lowpass || by.what == Unknown::highpass)
    return corner_derivative(here, by.index, by.what == Unknown::highpass);
  if (by.what == Unknown::clock) return {here.A, MatrixXd()};
  if (by.what == Unknown::drive) {
    Parts out{MatrixXd::Zero(states_, states_), MatrixXd()};
    add_process(at.drive, true, out.A);
    return out;
  }
  return {};
}

LinearModel MotionModel::at(const VectorXd& theta, bool derivatives) const {
  const int elements = rig_.element_count();
  Coefficients now{
      VectorXd::Zero(elements), VectorXd::Zero(elements), Eigen::Map<const VectorXd>(rig_.masses.data(), n_),
      VectorXd::Zero(n_),       VectorXd::Zero(n_),       VectorXd::Zero(static_cast<Eigen::Index>(apart_.size()))};
  Rig rig = rig_;
  for (std::size_t a = 0; a < parameters_.size(); ++a) {
    const Parameter& p = parameters_[a];
    const double value = theta(static_cast<Eigen::Index>(a));
    if (p.what == Unknown::stiffness) now.stiffness(p.index) = value;
    if (p.what == Unknown::damping) now.damping(p.index) = value;
    if (p.what == Unknown::ground_stiffness) now.ground_stiffness(p.index) = value;
    if (p.what == Unknown::ground_damping) now.ground_damping(p.index) = value;
    if (p.what == Unknown::side_stiffness) now.side_stiffness(p.index) = value;
    if (p.what == Unknown::drive) now.drive = value;
    if (p.what == Unknown::mass) now.inverse_mass(p.index) += value;
    const auto i = static_cast<std::size_t>(p.index);
    if (p.what == Unknown::lowpass) rig.channels[i].lowpass.hz += value;
    if (p.what == Unknown::highpass) rig.channels[i].highpass.hz += value;
  }
  now.inverse_mass = now.inverse_mass.cwiseInverse().eval();
  MotionModel moved(*this);
  moved.rig_ = std::move(rig);
  const Parts here = moved.parts(now, Of::all);
  LinearModel out{here.A, here.C, {}, {}, noise_state(), {}, {}, {}};
  moved.add_inputs(now, here, out);
  double clock = 0.0;
  for (std::size_t a = 0; a < parameters_.size(); ++a) {
    if (parameters_[a].what == Unknown::clock) clock = theta(static_cast<Eigen::Index>(a));
    if (!derivatives) continue;
    Parts by = moved.derivative(parameters_[a], now, here);
    out.dA.push_back(std::move(by.A));
    out.dC.push_back(std::move(by.C));
  }
  for (int c = 0; c < static_cast<int>(rig_.channels.size()); ++c) state_row(c, theta, here, out);
  out.A *= 1.0 + clock;
  for (std::size_t a = 0; a < out.dA.size(); ++a)
    if (parameters_[a].what != Unknown::clock) out.dA[a] *= 1.0 + clock;
  return out;
}

// A unit force in an element acts as its stiffness does where it is deformed by one; one between a mass and ground as a
// spring there does where the table's own displacement, which moves all masses alike, is one.
void MotionModel::add_inputs(const Coefficients& now, const Parts& here, LinearModel& out) const {
  for (std::size_t a = 0; a < parameters_.size(); ++a)
    if (is_input(parameters_[a].what)) out.inputs.push_back(static_cast<int>(a));
  out.B.resize(states_, static_cast<Eigen::Index>(out.inputs.size()));
  out.D.resize(out.C.rows(), out.B.cols());
  for (Eigen::Index i = 0; i < out.B.cols(); ++i) {
    const Parameter& input = parameters_[static_cast<std::size_t>(out.inputs[static_cast<std::size_t>(i)])];
    if (input.what == Unknown::ground_friction) {
      const Parts by = derivative({Unknown::ground_stiffness, input.index}, now, here);
      out.B.col(i) = by.A.col(0);
      out.D.col(i) = by.C.col(0);
      continue;
    }
    const int element = input.index;
    const Parts by = derivative({Unknown::stiffness, element}, now, here);
    const int state = element < n_ ? table_ + element : 0;  // deformation_row() is ±1 there
    const double sign = element < n_ ? 1.0 : -1.0;
    out.B.col(i) = sign * by.A.col(state);
    out.D.col(i) = sign * by.C.col(state);
  }
}

// Scales and delays act on a whole row: (1 + scale) C_c e^(-δ A), δ the delay's departure from the rig file. Only the
// first terms of the series are used: the whole exponential extrapolates a fast state backwards without bound.
void MotionModel::state_row(int c, const VectorXd& theta, const Parts& here, LinearModel& out) const {
  const int device = rig_.channels[static_cast<std::size_t>(c)].device;
  const auto delays = [&](const Parameter& p) {
    return (p.what == Unknown::delay && p.index == c) || (p.what == Unknown::device_delay && p.index == device);
  };
  const auto scales = [&](const Parameter& p) { return p.what == Unknown::scale && p.index == c; };
  double late = 0.0, scale = 1.0;
  for (std::size_t a = 0; a < parameters_.size(); ++a) {
    if (delays(parameters_[a])) late += theta(static_cast<Eigen::Index>(a));
    if (scales(parameters_[a])) scale += theta(static_cast<Eigen::Index>(a));
  }
  std::array<RowVectorXd, kDelayTerms + 1> terms;
  terms[0] = here.C.row(c);
  RowVectorXd row = terms[0], by_delay = RowVectorXd::Zero(states_);
  for (std::size_t k = 1; k <= kDelayTerms; ++k) {
    by_delay -= terms[k - 1] * here.A;
    terms[k] = -late / static_cast<double>(k) * (terms[k - 1] * here.A);
    row += terms[k];
  }
  out.C.row(c) = scale * row;
  if (out.D.cols() > 0) out.D.row(c) *= scale;
  for (std::size_t a = 0; a < out.dC.size(); ++a) {
    MatrixXd &dC = out.dC[a], &dA = out.dA[a];
    const bool moves_row = dC.size() > 0 || delays(parameters_[a]) || scales(parameters_[a]);
    const bool moves_delayed = late != 0.0 && dA.size() > 0 && parameters_[a].what != Unknown::clock;
    if (!moves_row && !moves_delayed) continue;
    if (dC.size() == 0) dC = MatrixXd::Zero(out.C.rows(), states_);
    if (scales(parameters_[a])) {
      dC.row(c) = row;
      continue;
    }
    if (delays(parameters_[a])) {
      dC.row(c) = scale * by_delay;
      continue;
    }
    RowVectorXd by = dC.row(c), sum = by;
    for (std::size_t k = 1; k <= kDelayTerms && late != 0.0; ++k) {
      by = by * here.A;
      if (dA.size() > 0) by += terms[k - 1] * dA;
      by *= -late / static_cast<double>(k);
      sum += by;
    }
    dC.row(c) = scale * sum;
  }
}

}  // namespace dwell
