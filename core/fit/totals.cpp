#include "core/fit/totals.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {

Totals::Totals(int channels, int harmonics)
    : channels_(channels),
      instants_count_(2 * harmonics + 1),
      readings_count_(harmonics + 1),
      instants_(moments::size(instants_count_) * static_cast<std::size_t>(channels)),
      readings_(moments::size(readings_count_) * static_cast<std::size_t>(channels)),
      owner_(static_cast<std::size_t>(channels), -1) {}

double* Totals::instants(int c) noexcept {
  return &instants_[moments::size(instants_count_) * static_cast<std::size_t>(c)];
}
double* Totals::readings(int c) noexcept {
  return &readings_[moments::size(readings_count_) * static_cast<std::size_t>(c)];
}

void Totals::restart(double omega, std::int64_t t_ref_ns) noexcept {
  omega_ = omega;
  t_ref_ns_ = t_ref_ns;
  std::fill(instants_.begin(), instants_.end(), 0.0);
  std::fill(readings_.begin(), readings_.end(), 0.0);
  std::fill(owner_.begin(), owner_.end(), -1);
}

void Totals::restart_channel(int c, double omega, std::int64_t t_ref_ns) noexcept {
  omega_ = omega;
  t_ref_ns_ = t_ref_ns;
  owner_[static_cast<std::size_t>(c)] = c;
  std::fill_n(instants(c), moments::size(instants_count_), 0.0);
  std::fill_n(readings(c), moments::size(readings_count_), 0.0);
}

void Totals::share(int c, int owner) noexcept {
  int& shared = owner_[static_cast<std::size_t>(c)];
  if (shared == owner || shared == c) return;
  if (shared >= 0) std::copy_n(instants(shared), moments::size(instants_count_), instants(c));
  shared = shared < 0 ? owner : c;
}

void Totals::add(int c, const ChannelMoments& sets, const moments::Turn& turn) noexcept {
  if (owner_[static_cast<std::size_t>(c)] == c)
    moments::add_instants(sets.instants, instants_count_, turn, instants(c));
  moments::add_readings(sets.readings, readings_count_, turn, moments::mean_square_u(sets.instants, instants_count_),
                        readings(c));
}

ChannelMoments Totals::channel(int c) const noexcept {
  const auto i = static_cast<std::size_t>(c);
  const auto owner = static_cast<std::size_t>(std::max(owner_[i] < 0 ? c : owner_[i], 0));
  return {&instants_[moments::size(instants_count_) * owner], &readings_[moments::size(readings_count_) * i]};
}

std::int64_t Totals::centroid_ns(int c) const noexcept {
  const double* set = channel(c).instants;
  if (!(set[0] > 0)) return t_ref_ns_;
  return t_ref_ns_ +
         static_cast<std::int64_t>(std::llround(1e9 * set[moments::cosine(instants_count_, 1, 0)] / set[0]));
}

moments::Turn Totals::turn_from(double omega, std::int64_t centre_ns, double faster, double ahead) const noexcept {
  const double shift = 1e-9 * static_cast<double>(centre_ns - t_ref_ns_);
  return {omega_ - omega + faster, omega_ * shift + ahead, shift, instants_count_};
}

void Totals::turned(double omega, std::int64_t t_ref_ns, Totals& out) const noexcept {
  out.restart(omega, t_ref_ns);
  out.owner_ = owner_;
  const moments::Turn turn = out.turn_from(omega_, t_ref_ns_);
  for (int c = 0; c < channels_; ++c) {
    const ChannelMoments from = channel(c);
    const int owner = owner_[static_cast<std::size_t>(c)];
    if (owner == c || owner < 0) moments::add_instants(from.instants, instants_count_, turn, out.instants(c));
    moments::add_readings(from.readings, readings_count_, turn, moments::mean_square_u(from.instants, instants_count_),
                          out.readings(c));
  }
}

}  // namespace dwell
