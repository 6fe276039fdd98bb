// What the table's transducer read, as a function of time: the cubic spline through its samples, twice continuously
// differentiable (C. de Boor, A Practical Guide to Splines, 1978, chapter IV; at the ends the slope of the cubic
// through the first and last four samples). Several readings at the same instants are carried side by side: the
// measured one, and draws of its noise.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace dwell {

class VirtualTestInput {
 public:
  // t_ns: strictly increasing, at least four, instants of the motion (delay already taken off). values: one row per
  // reading, one column per instant. O(readings · instants), allocates.
  VirtualTestInput(std::vector<std::int64_t> t_ns, Eigen::MatrixXd values);

  [[nodiscard]] std::size_t knots() const noexcept { return t_ns_.size(); }
  [[nodiscard]] std::int64_t knot_ns(std::size_t i) const noexcept { return t_ns_[i]; }
  [[nodiscard]] Eigen::Index readings() const noexcept { return values_.rows(); }

  // (u, u', u'', u''') of every reading, `after_s` behind knot i, by the cubic that begins there; i + 1 < knots().
  // out: 4 × readings(). No allocation.
  void at(std::size_t i, double after_s, Eigen::Ref<Eigen::MatrixXd> out) const noexcept;

 private:
  std::vector<std::int64_t> t_ns_;
  Eigen::MatrixXd values_, curvatures_;  // u'' at the knots
};

}  // namespace dwell
