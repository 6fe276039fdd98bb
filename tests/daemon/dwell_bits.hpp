// Everything that a Dwell holds as bytes: two dwells are the same to the bit where these are equal.
#pragma once

#include <cstring>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "core/result/dwell.hpp"

namespace dwell::test {

class DwellBits {
 public:
  static std::string of(const Dwell& dwell) {
    DwellBits bits;
    bits.add(dwell);
    return std::move(bits.bytes_);
  }

 private:
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof value);
  }
  void add(const std::string& text) {
    add(text.size());
    bytes_ += text;
  }
  template <class T>
  void add(const std::vector<T>& values) {
    add(values.size());
    for (const T& value : values) add(value);
  }
  void add(const Estimate& e) { all(e.value, e.u); }
  void add(const Coefficient& c) { all(c.value, c.u, c.dof, c.U95, c.significant); }
  void add(const BudgetShare& s) { all(s.source, s.stiffness_share, s.damping_share, s.kind, s.channel); }
  void add(const Doubt& d) { all(d.elements, d.what, d.by_chance); }
  void add(const Warning& w) { all(w.kind, w.what); }
  void add(const ReadingError& r) { all(r.channel, r.relative, r.late_s, r.lowpass_hz, r.highpass_hz); }
  void add(const CoefficientError& e) { all(e.on_coefficients, e.mass, e.mass_u, e.clock_u, e.readings); }
  void add(const ChannelPhasor& p) {
    all(p.Y.real(), p.Y.imag(), p.u_amplitude, p.u_phase_rad, p.u_relative_phase_rad, p.mean, p.harmonics, p.sigma,
        p.samples, p.valid, p.reason);
  }
  void add(const ElementEstimate& e) {
    all(e.k, e.identifiable, e.reason, e.deformation, e.stiffness, e.damping, e.loss_factor, e.budget);
  }
  void add(const Dwell& d) {
    all(d.index.value_or(-1), d.state, d.ended_by, d.start_s, d.settled_s, d.verdict_s, d.end_s, d.memory_time_s,
        d.memory_time_predicted_s, d.settles_in_s, d.settling_reason, d.frequency_hz, d.t_ref_s, d.phasors, d.elements,
        d.covariance, d.errors, d.warnings, d.doubts, d.unstated);
  }
  template <class... T>
  void all(const T&... values) {
    (add(values), ...);
  }

  std::string bytes_;
};

}  // namespace dwell::test
