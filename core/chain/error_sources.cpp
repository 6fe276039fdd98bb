#include "core/chain/error_sources.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/complex.hpp"
#include "core/chain/identify.hpp"
#include "core/chain/observed.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::VectorXcd;
using Index = Eigen::Index;

constexpr double kTypeB = std::numeric_limits<double>::infinity();  // degrees of freedom of a type B source

// Name of the device. If the device has several transactions, the channels of this one too: "line (y0, y1, y2 …)".
std::string name_of_transaction(const Rig& rig, const std::vector<Evidence>& evidence, int transaction) {
  constexpr int kNamed = 3;
  const int device = rig.channels[static_cast<std::size_t>(transaction)].device;
  std::string members;
  int count = 0;
  bool others = false;
  for (std::size_t c = 0; c < evidence.size(); ++c) {
    if (rig.channels[c].device != device) continue;
    if (evidence[c].transaction != transaction && static_cast<int>(c) != transaction) {
      others = others || evidence[c].turnaround_u_s > 0;
    } else if (++count <= kNamed) {
      members += (members.empty() ? "" : ", ") + rig.channels[c].name;
    }
  }
  if (count > kNamed) members += " …";
  if (device < 0) return members;
  return rig.devices[static_cast<std::size_t>(device)].name + (others ? " (" + members + ")" : "");
}

// Collects the sources; each method adds those of one kind.
class Collection {
 public:
  Collection(const Gain& gain, const std::vector<Evidence>& evidence, const VectorXcd& o, const ChainState& chain,
             const ElementStates& elements)
      : gain_(gain), evidence_(evidence), o_(o), chain_(chain), elements_(elements) {}

  void add_noise(Index c);
  void add_stated(Index c);
  // Delays that the channels of a device share, turnarounds that the channels of a transaction share, uneven stamps.
  void add_shared_instants();
  void add_masses();
  void add_taken_for_transient();
  void add_change_within();
  void add_frequency(const Frequency& frequency);

  [[nodiscard]] bool counts(Index c) const { return seen(c).usable && !gain_.gain.col(c).isZero(0); }
  std::vector<ErrorSource>& sources() { return out_; }

 private:
  // Error of an instant that several channels share.
  struct Shared {
    VectorXcd on_x, bends_x;
    std::vector<ReadingError> readings;
  };

  [[nodiscard]] const Evidence& seen(Index c) const { return evidence_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] const Channel& channel(Index c) const { return chain_.rig.channels[static_cast<std::size_t>(c)]; }
  [[nodiscard]] VectorXcd no_x() const { return VectorXcd::Zero(chain_.n + 2); }
  [[nodiscard]] VectorXcd no_Z() const { return VectorXcd::Zero(elements_.Z.size()); }
  [[nodiscard]] VectorXcd through_channel(Index c, Complex change) const { return gain_.gain.col(c) * change; }
  [[nodiscard]] Complex delayed(Index c) const { return Complex{0.0, chain_.omega} * o_(c); }  // ∂o/∂τ
  // ∂²o/∂τ² u²/2
  [[nodiscard]] Complex bent(Index c, double u_s) const {
    return 0.5 * Complex{0.0, chain_.omega} * delayed(c) * u_s * u_s;
  }
  // Of the readings of one channel alone. name: its channel's name follows.
  void add_of_channel(SourceKind kind, const char* name, Index c, VectorXcd on_x, const ReadingError& reading,
                      VectorXcd bends_x = {}) {
    out_.push_back({.name = name + channel(c).name,
                    .dof = kTypeB,
                    .on_x = std::move(on_x),
                    .on_Z = no_Z(),
                    .readings = {reading},
                    .bends_x = std::move(bends_x),
                    .kind = kind,
                    .channel = channel(c).name});
  }
  void add_late(SourceKind kind, const char* name, Index c, double u_s) {
    if (u_s > 0)
      add_of_channel(kind, name, c, through_channel(c, delayed(c) * u_s), {.channel = c, .late_s = u_s},
                     through_channel(c, bent(c, u_s)));
  }
  [[nodiscard]] std::string name_of_device(int device) const {
    return device < 0 ? std::string() : chain_.rig.devices[static_cast<std::size_t>(device)].name;
  }
  void add_shared(SourceKind kind, std::string name, std::string device, Shared shared) {
    out_.push_back({.name = std::move(name),
                    .dof = kTypeB,
                    .on_x = std::move(shared.on_x),
                    .on_Z = no_Z(),
                    .readings = std::move(shared.readings),
                    .bends_x = std::move(shared.bends_x),
                    .kind = kind,
                    .device = std::move(device)});
  }
  void share(std::map<int, Shared>& of, int key, Index c, double u_s) const {
    Shared& shared = of.try_emplace(key, Shared{no_x(), no_x(), {}}).first->second;
    shared.on_x += through_channel(c, delayed(c) * u_s);
    shared.bends_x += through_channel(c, bent(c, u_s));
    shared.readings.push_back({.channel = c, .late_s = u_s});
  }

  const Gain& gain_;
  const std::vector<Evidence>& evidence_;
  const VectorXcd& o_;
  const ChainState& chain_;
  const ElementStates& elements_;
  std::vector<ErrorSource> out_;
};

// Adds the errors that are independent between channels: noise, remaining transient, quantization, folded harmonics.
void Collection::add_noise(Index c) {
  const Evidence& seen = this->seen(c);
  const Complex per_reading = as_observed(chain_.rig, static_cast<int>(c), 1.0, chain_.omega, 1);
  Eigen::Matrix2d turn;
  turn << per_reading.real(), -per_reading.imag(), per_reading.imag(), per_reading.real();
  // Each 2 × 2 covariance gives two independent errors, along its principal axes.
  const double rounding = std::norm(per_reading) * seen.quantization_u * seen.quantization_u;
  struct Part {
    SourceKind kind;
    const char* name;
    Eigen::Matrix2d covariance;
    double dof;
  };
  const Eigen::Matrix2d one = Eigen::Matrix2d::Identity();
  for (const auto& [kind, name, covariance, dof] :
       {Part{SourceKind::noise, "noise of ", turn * seen.covariance * turn.transpose(), seen.dof},
        Part{SourceKind::transient_left, "transient left in ", turn * seen.transient * turn.transpose(), kTypeB},
        Part{SourceKind::quantization, "quantization of ", rounding * one, kTypeB},
        Part{SourceKind::folded_harmonics, "folded harmonics of ",
             std::norm(per_reading) * seen.folded_u * seen.folded_u * one, kTypeB}}) {
    if (covariance.isZero(0)) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(covariance);
    for (Index axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d step = axes.eigenvectors().col(axis) * std::sqrt(std::max(0.0, axes.eigenvalues()(axis)));
      out_.push_back({.name = name + channel(c).name,
                      .dof = dof,
                      .on_x = through_channel(c, {step(0), step(1)}),
                      .on_Z = no_Z(),
                      .residual = std::isfinite(dof),
                      .kind = kind,
                      .channel = channel(c).name});
    }
  }
}

// Adds the systematic errors of this channel alone: scale, refresh of its register, uneven readings, delay, filters.
void Collection::add_stated(Index c) {
  const Channel& channel = this->channel(c);
  const LogSlopes slopes = response_slopes(channel, device_delay_s(chain_.rig, channel), chain_.omega / (kTwoPi));
  if (channel.scale_u > 0)
    add_of_channel(SourceKind::scale, "scale of ", c, through_channel(c, o_(c) * channel.scale_u),
                   {.channel = c, .relative = channel.scale_u});
  add_late(SourceKind::refresh, "refresh of ", c, seen(c).refresh_u_s);
  add_late(SourceKind::uneven, "uneven readings of ", c, seen(c).uneven.own_s);
  if (seen(c).uneven.part > 0)
    add_of_channel(SourceKind::uneven, "uneven readings of ", c, through_channel(c, o_(c) * seen(c).uneven.part),
                   {.channel = c, .relative = seen(c).uneven.part});
  add_late(SourceKind::delay, "delay of ", c, channel.delay_u_s);
  if (channel.lowpass.hz_u > 0)
    add_of_channel(SourceKind::lowpass, "low-pass of ", c,
                   through_channel(c, -o_(c) * slopes.lowpass_corner * channel.lowpass.hz_u),
                   {.channel = c, .lowpass_hz = channel.lowpass.hz_u});
  if (channel.highpass.hz_u > 0)
    add_of_channel(SourceKind::highpass, "high-pass of ", c,
                   through_channel(c, -o_(c) * slopes.highpass_corner * channel.highpass.hz_u),
                   {.channel = c, .highpass_hz = channel.highpass.hz_u});
}

void Collection::add_shared_instants() {
  const Rig& rig = chain_.rig;
  std::map<int, Shared> by_device, by_transaction, by_stamps;
  for (Index c = 0; c < o_.size(); ++c) {
    if (!counts(c)) continue;
    if (const int device = channel(c).device; device >= 0)
      if (const double u = rig.devices[static_cast<std::size_t>(device)].delay_u_s; u > 0)
        share(by_device, device, c, u);
    if (const Evidence& seen = this->seen(c); seen.turnaround_u_s > 0)
      share(by_transaction, seen.transaction >= 0 ? seen.transaction : static_cast<int>(c), c, seen.turnaround_u_s);
    if (const UnevenReadings& uneven = this->seen(c).uneven; uneven.with >= 0)
      share(by_stamps, uneven.with, c, uneven.shared_s);
  }
  for (auto& [device, shared] : by_device)
    add_shared(SourceKind::delay, "delay of " + name_of_device(device), name_of_device(device), std::move(shared));
  for (auto& [transaction, shared] : by_transaction)
    add_shared(SourceKind::turnaround, "turnaround of " + name_of_transaction(rig, evidence_, transaction),
               name_of_device(channel(transaction).device), std::move(shared));
  for (auto& [group, shared] : by_stamps)
    add_shared(SourceKind::uneven, "uneven stamps of " + channel(group).name + " and others", "", std::move(shared));
}

void Collection::add_masses() {
  const std::vector<double>& mass_u = chain_.rig.mass_u;
  for (std::size_t i = 0; i < mass_u.size(); ++i) {
    if (!(mass_u[i] > 0)) continue;
    VectorXcd on_Z = no_Z();
    for (Index e = 0; e <= static_cast<Index>(i) && e < chain_.n; ++e)
      on_Z(e) = chain_.omega * chain_.omega * chain_.Y(static_cast<int>(i) + 1) * mass_u[i] / elements_.d(e);
    out_.push_back({.name = "mass " + std::to_string(i + 1),
                    .dof = kTypeB,
                    .on_x = no_x(),
                    .on_Z = on_Z,
                    .mass = static_cast<int>(i) + 1,
                    .kind = SourceKind::mass});
  }
}

// Adds the response to a change of the drive while settling. The fit may have taken it for a transient.
void Collection::add_taken_for_transient() {
  VectorXcd absorbed = no_x();
  for (Index c = 0; c < o_.size(); ++c)
    if (seen(c).usable)
      absorbed += through_channel(
          c, as_observed(chain_.rig, static_cast<int>(c), seen(c).taken_for_transient, chain_.omega, 1));
  if (!absorbed.isZero(0))
    out_.push_back({.name = "drive's change while settling",
                    .dof = kTypeB,
                    .on_x = absorbed,
                    .on_Z = no_Z(),
                    .kind = SourceKind::drive_settling});
}

// Adds the error of Z_k by phasors that change within the dwell, by a transient, a drive that hunts or a knock.
// With y = Im(Y(t) exp(jωt)) the equations of motion hold at every instant. To first order in the slope Ẏ, the inertia
// has the additional term -2jω Σ m_i Ẏ_i, the damper the term r_k ḋ_k. The computed Z_k is therefore too large by
//
//   (2jω Σ_{i>=k} m_i Ẏ_i + r_k ḋ_k) / d_k ,   element n+1: r_{n+1} Ẏ_n / Y_n .
//
// It adds nothing if no channel has a significant slope.
void Collection::add_change_within() {
  const int n = chain_.n;
  const VectorXcd &Z = elements_.Z, &d = elements_.d;
  bool shows = false;
  VectorXcd slopes = VectorXcd::Zero(gain_.gain.cols()), read_off = slopes;
  for (Index c = 0; c < slopes.size(); ++c) {
    if (!counts(c)) continue;
    shows = shows || seen(c).slope.shows();
    slopes(c) = as_observed(chain_.rig, static_cast<int>(c), seen(c).slope.value, chain_.omega, 1);
    // A velocity transducer reads jωY + Ẏ, so the displacement is read too large by Ẏ/(jω); acceleration: twice that.
    read_off(c) = slopes(c) * static_cast<double>(derivative_order(channel(c).measures)) / Complex{0.0, chain_.omega};
  }
  if (!shows) return;
  const VectorXcd x_dot = gain_.gain * slopes;
  VectorXcd on_Z(Z.size());
  Complex inertia = 0.0;
  if (Z.size() > n) on_Z(n) = damping(Z(n), chain_.omega) * x_dot.head(n + 1).sum() / d(n);
  for (int k = n; k >= 1; --k) {
    inertia += chain_.rig.masses[static_cast<std::size_t>(k - 1)] * x_dot.head(k + 1).sum();
    on_Z(k - 1) = (Complex{0.0, 2 * chain_.omega} * inertia + damping(Z(k - 1), chain_.omega) * x_dot(k)) / d(k - 1);
  }
  out_.push_back({.name = "change within the dwell",
                  .dof = kTypeB,
                  .on_x = gain_.gain * read_off,
                  .on_Z = on_Z,
                  .kind = SourceKind::change_within});
}

void Collection::add_frequency(const Frequency& frequency) {
  const double omega = chain_.omega;
  VectorXcd x_per_omega = no_x();  // ∂x/∂ω through the transducers
  for (Index c = 0; c < o_.size(); ++c) {
    if (!counts(c)) continue;
    const LogSlopes slopes = response_slopes(channel(c), device_delay_s(chain_.rig, channel(c)), omega / (kTwoPi));
    x_per_omega += through_channel(
        c, -o_(c) * (static_cast<double>(derivative_order(channel(c).measures)) / omega + slopes.frequency / (kTwoPi)));
  }
  VectorXcd by_omega = no_Z();  // 2ω Σ_{i>=k} m_i Y_i / d_k
  Complex inertia = 0.0;
  for (int k = chain_.n; k >= 1; --k) {
    inertia += chain_.rig.masses[static_cast<std::size_t>(k - 1)] * chain_.Y(k);
    by_omega(k - 1) = 2 * omega * inertia / elements_.d(k - 1);
  }
  const auto add = [&](SourceKind kind, const char* name, double u, double clock_u) {
    if (u > 0)
      out_.push_back({.name = name,
                      .dof = kTypeB,
                      .on_x = x_per_omega * u,
                      .on_Z = by_omega * u,
                      .on_omega = u,
                      .clock_u = clock_u,
                      .kind = kind});
  };
  add(SourceKind::frequency, "frequency", frequency.u, 0.0);
  add(SourceKind::clock_rate, "clock rate", frequency.clock_u * omega, frequency.clock_u);
}

}  // namespace

std::vector<ErrorSource> sources_of(const Gain& gain, const std::vector<Evidence>& evidence, const VectorXcd& o,
                                    const ChainState& chain, const ElementStates& elements,
                                    const Frequency& frequency) {
  Collection all(gain, evidence, o, chain, elements);
  for (Index c = 0; c < o.size(); ++c) {
    if (!all.counts(c)) continue;
    all.add_noise(c);
    all.add_stated(c);
  }
  all.add_shared_instants();
  all.add_masses();
  all.add_taken_for_transient();
  all.add_change_within();
  all.add_frequency(frequency);
  return std::move(all.sources());
}

}  // namespace dwell
