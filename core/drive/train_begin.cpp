#include "core/drive/train_begin.hpp"

#include <algorithm>
#include <cmath>

#include "core/drive/next_pulse.hpp"

namespace dwell {
namespace {

double interval_s(std::int64_t from_ns, std::int64_t to_ns) { return static_cast<double>(to_ns - from_ns) * 1e-9; }

}  // namespace

TrainBegin::TrainBegin(double low_hz, double high_hz) noexcept
    : shortest_s_((1 - NextPulse::kJitter) / high_hz), longest_s_((1 + NextPulse::kJitter) / low_hz) {}

bool TrainBegin::add(std::int64_t t_ns) noexcept {
  const bool full = count_ == kBegin;
  if (full) {
    std::copy(waiting_.begin() + 1, waiting_.end(), waiting_.begin());
    --count_;
  }
  waiting_[count_++] = t_ns;
  return full;
}

std::optional<double> TrainBegin::period_s() const noexcept {
  if (count_ < kBegin) return std::nullopt;
  const double mean_s = interval_s(waiting_.front(), waiting_.back()) / static_cast<double>(kBegin - 1);
  if (mean_s < shortest_s_ || mean_s > longest_s_) return std::nullopt;
  for (std::size_t i = 1; i < kBegin; ++i)
    if (std::abs(interval_s(waiting_[i - 1], waiting_[i]) - mean_s) > NextPulse::kJitter * mean_s) return std::nullopt;
  return mean_s;
}

}  // namespace dwell
