#include "daemon/handon/trace.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dwell::handon {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

Trace::Trace() : low_(kInfinity), high_(-kInfinity) { bins_.fill({kInfinity, -kInfinity}); }

void Trace::take(double part, double x) noexcept {
  ++count_;
  if (!std::isfinite(x)) return;
  const auto at = static_cast<std::size_t>(std::clamp(part, 0.0, 1.0) * static_cast<double>(kBins));
  Bin& bin = bins_[std::min(at, kBins - 1)];
  bin = {std::min(bin.low, x), std::max(bin.high, x)};
  low_ = std::min(low_, x);
  high_ = std::max(high_, x);
}

}  // namespace dwell::handon
