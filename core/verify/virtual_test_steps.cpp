#include "core/verify/virtual_test_steps.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/instants.hpp"

namespace dwell {
namespace {

constexpr double kLongestSeries = 0.5;  // of fastest · dt in one series …
constexpr int kSeriesTerms = 15;        // … so that 0.5^16 / 16! < 1e-18 is left off

}  // namespace

void VirtualTestSteps::series(double dt_s, Eigen::MatrixXd& z) {
  const double steps = std::max(1.0, std::ceil(model_.fastest() * dt_s / kLongestSeries));
  const double h_s = dt_s / steps;
  for (double step = 0; step < steps; ++step) {
    term_ = z;
    for (int i = 1; i <= kSeriesTerms; ++i) {
      product_.noalias() = model_.matrix().lazyProduct(term_);
      term_ = product_ * (h_s / i);
      z += term_;
    }
  }
}

void VirtualTestSteps::apply(std::int64_t dt_ns, Eigen::MatrixXd& z) {
  if (dt_ns == 0 || model_.states() == 0) return;
  auto hash = static_cast<std::uint64_t>(dt_ns);
  hash = (hash * 0x9E3779B97F4A7C15U) >> 58U;
  Kept& kept = kept_[hash % kSlots];
  if (kept.dt_ns != dt_ns) {
    kept.dt_ns = dt_ns;
    kept.again = false;
    return series(to_s(dt_ns), z);
  }
  if (!kept.again) {
    kept.again = true;
    Eigen::MatrixXd whole = Eigen::MatrixXd::Identity(z.rows(), z.rows());
    series(to_s(dt_ns), whole);
    kept.exponential = whole.topRows(model_.states());
  }
  product_.noalias() = kept.exponential.lazyProduct(z);
  z.topRows(model_.states()) = product_;
}

}  // namespace dwell
