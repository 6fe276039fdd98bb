#include "core/drive/sync_reference.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/instants.hpp"

namespace dwell {

SyncReference::SyncReference(double low_hz, double high_hz) : strays_(low_hz, high_hz) {}

bool SyncReference::present(std::int64_t t_ns) const noexcept {
  return train_.number != 0 &&
         static_cast<double>(t_ns - newest_ns()) * 1e-9 <= std::max(kSilent_s, kLostPeriods * next_.T_s());
}

void SyncReference::pulse(std::int64_t t_ns) noexcept {
  if (train_.number != 0 && !present(t_ns)) train_ = {};  // periods cannot be counted over so long a silence
  if (train_.number != 0) {
    const double periods = next_.periods_to(t_ns), allowed = next_.allowed();
    const double step = std::round(periods);
    if (step < 1 && std::abs(periods) <= allowed) {  // the newest pulse again
      ++counts_.extra;
      return;
    }
    if (step >= 1 && step <= kFarthest && std::abs(periods - step) <= allowed) {
      counts_.extra += strays_.pulses().size();
      strays_.clear();
      counts_.missed += static_cast<std::uint64_t>(step) - 1;
      accept(t_ns, next_.newest_k() + static_cast<std::int64_t>(step));
      return;
    }
  }
  if (strays_.add(t_ns)) ++counts_.extra;
  if (const auto period_s = strays_.period_s()) begin_train(*period_s);
}

void SyncReference::begin_train(double period_s) noexcept {
  train_ = {++trains_, strays_.pulses().front(), period_s};
  next_.begin(period_s);
  std::int64_t k = 0;
  for (const std::int64_t t_ns : strays_.pulses()) accept(t_ns, k++);
  strays_.clear();
}

void SyncReference::accept(std::int64_t t_ns, std::int64_t k) noexcept {
  ++counts_.pulses;
  next_.take(t_ns, k);
  runs_.keep(train_, t_ns, k);
}

}  // namespace dwell
