#include "core/verify/virtual_test_input.hpp"

#include <cassert>
#include <utility>

#include "core/base/instants.hpp"

namespace dwell {
namespace {

using Eigen::Index;

// Slope at t_ns[at] of the cubic through the four samples that begin at `first`: derivatives of Lagrange's polynomials.
Eigen::VectorXd slope_of_four(const std::vector<std::int64_t>& t_ns, const Eigen::MatrixXd& values, std::size_t first,
                              std::size_t at) {
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(values.rows());
  const auto gap_s = [&t_ns](std::size_t a, std::size_t b) { return to_s(t_ns[a] - t_ns[b]); };
  for (std::size_t i = first; i < first + 4; ++i) {
    double weight = 0.0;
    for (std::size_t j = first; j < first + 4; ++j) {
      if (j == i) continue;
      double product = 1.0 / gap_s(i, j);
      for (std::size_t k = first; k < first + 4; ++k)
        if (k != i && k != j) product *= gap_s(at, k) / gap_s(i, k);
      weight += product;
    }
    slope += weight * values.col(static_cast<Index>(i));
  }
  return slope;
}

}  // namespace

VirtualTestInput::VirtualTestInput(std::vector<std::int64_t> t_ns, Eigen::MatrixXd values)
    : t_ns_(std::move(t_ns)), values_(std::move(values)) {
  const std::size_t count = t_ns_.size();
  assert(count >= 4 && values_.cols() == static_cast<Index>(count));
  // The curvatures s_i solve h_{i-1} s_{i-1} + 2 (h_{i-1} + h_i) s_i + h_i s_{i+1} = 6 (Δ_i - Δ_{i-1}), Δ the slopes of
  // the chords; at an end the missing chord is the slope there. Thomas' algorithm, diagonally dominant.
  curvatures_.resize(values_.rows(), values_.cols());
  std::vector<double> upper(count);
  const auto h = [this](std::size_t i) { return to_s(t_ns_[i + 1] - t_ns_[i]); };
  Eigen::VectorXd before = slope_of_four(t_ns_, values_, 0, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const auto column = static_cast<Index>(i);
    const double left = i > 0 ? h(i - 1) : 0.0, right = i + 1 < count ? h(i) : 0.0;
    const Eigen::VectorXd chord = i + 1 < count
                                      ? Eigen::VectorXd((values_.col(column + 1) - values_.col(column)) / right)
                                      : slope_of_four(t_ns_, values_, count - 4, count - 1);
    const double pivot = 2 * (left + right) - (i > 0 ? left * upper[i - 1] : 0.0);
    upper[i] = right / pivot;
    curvatures_.col(column) = 6 * (chord - before) / pivot;
    if (i > 0) curvatures_.col(column) -= left / pivot * curvatures_.col(column - 1);
    before = chord;
  }
  for (std::size_t i = count - 1; i-- > 0;)
    curvatures_.col(static_cast<Index>(i)) -= upper[i] * curvatures_.col(static_cast<Index>(i) + 1);
}

void VirtualTestInput::at(std::size_t i, double after_s, Eigen::Ref<Eigen::MatrixXd> out) const noexcept {
  const double h = to_s(t_ns_[i + 1] - t_ns_[i]);
  const auto k = static_cast<Index>(i);
  for (Index r = 0; r < values_.rows(); ++r) {
    const double s0 = curvatures_(r, k), third = (curvatures_(r, k + 1) - s0) / h;
    const double slope = (values_(r, k + 1) - values_(r, k)) / h - h * (2 * s0 + curvatures_(r, k + 1)) / 6;
    out(0, r) = values_(r, k) + after_s * (slope + after_s * (s0 / 2 + after_s * third / 6));
    out(1, r) = slope + after_s * (s0 + after_s * third / 2);
    out(2, r) = s0 + after_s * third;
    out(3, r) = third;
  }
}

}  // namespace dwell
