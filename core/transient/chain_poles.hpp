// Gives the poles of the chain itself, from which the fit of the transient starts. This is an interface because the
// identification of the chain stands in a room above and implements it (core/chain/provisional_chain.hpp).
#pragma once

#include <complex>
#include <span>

#include "core/transient/modal_fit.hpp"

namespace dwell {

// Poles in rad/s, slowest first; of a conjugate pair the one with Im > 0. Spans are valid until the next seen_by().
class ChainPoles {
 public:
  virtual ~ChainPoles() = default;
  // Poles of the chain identified from the steady phasors of `fit`; empty: these do not determine it. No allocation.
  [[nodiscard]] virtual std::span<const std::complex<double>> seen_by(const ModalFit& fit) noexcept = 0;
  // Poles of the chain that was identified last; empty: none has been.
  [[nodiscard]] virtual std::span<const std::complex<double>> last() const noexcept = 0;

 protected:
  ChainPoles() = default;
  ChainPoles(const ChainPoles&) = default;
  ChainPoles& operator=(const ChainPoles&) = default;
};

}  // namespace dwell
