#include "core/drive/pulse_runs.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"

namespace dwell {
std::int64_t PulseLine::nearest_ns(std::int64_t t_ns) const noexcept {
  const double T_s = kTwoPi / omega;
  return pulse_ns + std::llround(std::round(to_s(t_ns - pulse_ns) / T_s) * T_s * 1e9);
}

PulseRuns::PulseRuns() { runs_.reserve(kRuns); }

void PulseRuns::keep(const PulseTrain& train, std::int64_t t_ns, std::int64_t k) noexcept {
  if (runs_.size() == kRuns) runs_.erase(runs_.begin(), runs_.begin() + kRuns / 4);
  const auto place = static_cast<double>(k);
  const double x = to_s(t_ns - train.begin_ns) - place * train.T_s;
  runs_.push_back({train, t_ns, t_ns, 1.0, place, x, 0.0, 0.0, 0.0});
  std::size_t end = runs_.size();
  for (double length = 1.0;; length *= 2) {
    std::size_t begin = end;
    while (begin > 0 && runs_[begin - 1].n == length && runs_[begin - 1].train.number == train.number) --begin;
    if (end - begin <= kPerLength) return;
    join(runs_[begin], runs_[begin + 1]);
    runs_.erase(runs_.begin() + static_cast<std::ptrdiff_t>(begin) + 1);
    end = begin + 1;
  }
}

void PulseRuns::join(Run& into, const Run& other) noexcept {
  const double n = into.n + other.n, part = other.n / n, weight = into.n * part;
  const double k = other.k - into.k, x = other.x - into.x;
  into.kk += other.kk + weight * k * k;
  into.kx += other.kx + weight * k * x;
  into.xx += other.xx + weight * x * x;
  into.k += part * k;
  into.x += part * x;
  into.n = n;
  into.last_ns = other.last_ns;
}

template <class Take>
void PulseRuns::each_run(std::int64_t from_ns, std::int64_t to_ns, Take&& take) const noexcept {
  for (const Run& run : runs_)
    if (run.first_ns >= from_ns && run.last_ns <= to_ns) take(run);
}

std::optional<PulseLine> PulseRuns::over(std::int64_t from_ns, std::int64_t to_ns) const noexcept {
  Run all{}, now{};
  each_run(from_ns, to_ns, [&](const Run& run) {
    if (now.n > 0 && now.train.number == run.train.number)
      join(now, run);
    else
      now = run;
    if (now.n >= all.n) all = now;
  });
  if (all.n < kFewest || !(all.kk > 0)) return std::nullopt;
  const double slope = all.kx / all.kk, dof = all.n - 2;
  double variance = std::max(0.0, all.xx - slope * all.kx) / dof;
  double of_means = 0.0, means = 0.0;
  each_run(from_ns, to_ns, [&](const Run& run) {
    if (run.train.number != all.train.number) return;
    const double off = run.x - all.x - slope * (run.k - all.k);
    of_means += run.n * off * off;
    ++means;
  });
  if (means > 4) variance = std::max(variance, of_means / (means - 2));
  // Few residuals give an uncertain variance: u is the standard deviation of Student's t.
  const double T_s = all.train.T_s + slope, u_T_s = std::sqrt(variance / all.kk * dof / (dof - 2));
  const double k = std::round(all.k);
  const double pulse_s = k * all.train.T_s + all.x + (k - all.k) * slope;
  return PulseLine{kTwoPi / T_s, kTwoPi / T_s * u_T_s / T_s, all.train.begin_ns + std::llround(pulse_s * 1e9),
                   to_s(all.last_ns - all.first_ns)};
}

}  // namespace dwell
