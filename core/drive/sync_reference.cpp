#include "core/drive/sync_reference.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

constexpr double kJitter = 0.1;  // of a period, by which intervals may differ before the edges' own jitter is known
constexpr double kLeast = 0.02, kMost = 0.2;  // of a period, that a pulse may be off at all events, and at most
constexpr double kSureOfAPulse = 8.0;         // standard deviations within these

double to_s(std::int64_t ns) { return static_cast<double>(ns) * 1e-9; }

}  // namespace

std::int64_t PulseLine::nearest_ns(std::int64_t t_ns) const noexcept {
  const double T_s = kTwoPi / omega;
  return pulse_ns + std::llround(std::round(to_s(t_ns - pulse_ns) / T_s) * T_s * 1e9);
}

SyncReference::SyncReference(double low_hz, double high_hz)
    : shortest_s_((1 - kJitter) / high_hz), longest_s_((1 + kJitter) / low_hz) {
  runs_.reserve(kRuns);
}

bool SyncReference::present(std::int64_t t_ns) const noexcept {
  return train_.number != 0 && to_s(t_ns - newest_ns_) <= std::max(kLost_s, kLostPeriods * T_s_);
}

void SyncReference::pulse(std::int64_t t_ns) noexcept {
  if (train_.number != 0 && !present(t_ns)) train_ = {};  // over so long a silence periods cannot be counted
  if (train_.number != 0) {
    const double periods = (to_s(t_ns - newest_ns_) - due_s_) / T_s_;
    const double step = std::round(periods);
    // Few pulses foretell badly.
    const double wide = recents_ < kRecent ? kJitter : std::clamp(kSureOfAPulse * spread_s_ / T_s_, kLeast, kMost);
    if (step < 1 && std::abs(periods) <= wide) {  // the pulse that has been, once more
      ++counts_.extra;
      return;
    }
    if (step >= 1 && step <= kFarthest && std::abs(periods - step) <= wide) {
      counts_.extra += waits_;
      waits_ = 0;
      counts_.missed += static_cast<std::uint64_t>(step) - 1;
      accept(t_ns, newest_k_ + static_cast<std::int64_t>(step));
      return;
    }
  }
  if (waits_ == kBegin) {
    std::copy(waiting_.begin() + 1, waiting_.end(), waiting_.begin());
    --waits_;
    ++counts_.extra;
  }
  waiting_[waits_++] = t_ns;
  begin_train();
}

void SyncReference::begin_train() noexcept {
  if (waits_ < kBegin) return;
  const double mean_s = to_s(waiting_.back() - waiting_.front()) / static_cast<double>(kBegin - 1);
  if (mean_s < shortest_s_ || mean_s > longest_s_) return;
  for (std::size_t i = 1; i < kBegin; ++i)
    if (std::abs(to_s(waiting_[i] - waiting_[i - 1]) - mean_s) > kJitter * mean_s) return;
  train_ = {++trains_, waiting_.front(), mean_s};
  recents_ = 0;
  waits_ = 0;
  for (std::size_t i = 0; i < kBegin; ++i) accept(waiting_[i], static_cast<std::int64_t>(i));
}

void SyncReference::accept(std::int64_t t_ns, std::int64_t k) noexcept {
  ++counts_.pulses;
  newest_ns_ = t_ns;
  newest_k_ = k;
  recent_[recents_++ % kRecent] = {t_ns, k};
  foretell();
  keep(t_ns, k);
}

void SyncReference::foretell() noexcept {
  const std::size_t count = std::min(recents_, kRecent);
  double mean_k = 0.0, mean_t = 0.0, kk = 0.0, kt = 0.0, tt = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    mean_k += static_cast<double>(recent_[i].k - newest_k_) / static_cast<double>(count);
    mean_t += to_s(recent_[i].t_ns - newest_ns_) / static_cast<double>(count);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const double k = static_cast<double>(recent_[i].k - newest_k_) - mean_k;
    const double t = to_s(recent_[i].t_ns - newest_ns_) - mean_t;
    kk += k * k;
    kt += k * t;
    tt += t * t;
  }
  T_s_ = kk > 0 ? kt / kk : train_.T_s;
  due_s_ = kk > 0 ? mean_t - T_s_ * mean_k : 0.0;
  spread_s_ = count > 2 ? std::sqrt(std::max(0.0, tt - T_s_ * kt) / static_cast<double>(count - 2)) : 0.0;
}

void SyncReference::keep(std::int64_t t_ns, std::int64_t k) noexcept {
  if (runs_.size() == kRuns) runs_.erase(runs_.begin(), runs_.begin() + kRuns / 4);
  const auto place = static_cast<double>(k);
  const double x = to_s(t_ns - train_.begin_ns) - place * train_.T_s;
  runs_.push_back({train_, t_ns, t_ns, 1.0, place, x, 0.0, 0.0, 0.0});
  std::size_t end = runs_.size();
  for (double length = 1.0;; length *= 2) {
    std::size_t begin = end;
    while (begin > 0 && runs_[begin - 1].n == length && runs_[begin - 1].train.number == train_.number) --begin;
    if (end - begin <= kPerLength) return;
    join(runs_[begin], runs_[begin + 1]);
    runs_.erase(runs_.begin() + static_cast<std::ptrdiff_t>(begin) + 1);
    end = begin + 1;
  }
}

void SyncReference::join(Run& into, const Run& other) noexcept {
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
void SyncReference::each_run(std::int64_t from_ns, std::int64_t to_ns, Take&& take) const noexcept {
  for (const Run& run : runs_)
    if (run.first_ns >= from_ns && run.last_ns <= to_ns) take(run);
}

std::optional<PulseLine> SyncReference::over(std::int64_t from_ns, std::int64_t to_ns) const noexcept {
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
  // Few residuals tell little of how far the next may be off: the variance of Student's t.
  const double T_s = all.train.T_s + slope, u_T_s = std::sqrt(variance / all.kk * dof / (dof - 2));
  const double k = std::round(all.k);
  const double pulse_s = k * all.train.T_s + all.x + (k - all.k) * slope;
  return PulseLine{kTwoPi / T_s, kTwoPi / T_s * u_T_s / T_s, all.train.begin_ns + std::llround(pulse_s * 1e9),
                   to_s(all.last_ns - all.first_ns)};
}

}  // namespace dwell
