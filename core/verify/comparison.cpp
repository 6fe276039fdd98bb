#include "core/verify/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dwell {

double rms(const Eigen::Ref<const Eigen::VectorXd>& series) {
  return series.size() > 0 ? series.norm() / std::sqrt(static_cast<double>(series.size())) : 0.0;
}

void compare(const Eigen::Ref<const Eigen::VectorXd>& predicted, const Eigen::Ref<const Eigen::VectorXd>& measured,
             ChannelComparison& out) {
  out.samples = static_cast<std::size_t>(measured.size());
  out.rms = rms(measured);
  const double off = (predicted - measured).norm();
  out.error = off / measured.norm();
  out.fit_percent = 100 * (1 - off / (measured.array() - measured.mean()).matrix().norm());
  SpragueGeers& parts = out.sprague_geers;
  parts.magnitude = predicted.norm() / measured.norm() - 1;
  const double cosine = predicted.dot(measured) / (predicted.norm() * measured.norm());
  parts.phase = std::acos(std::clamp(cosine, -1.0, 1.0)) / std::numbers::pi;
  parts.combined = std::hypot(parts.magnitude, parts.phase);
}

}  // namespace dwell
