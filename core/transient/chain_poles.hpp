// Who knows the natural oscillations that the chain itself has. The model of the transient asks it for poles to begin
// with; what identifies the chain stands in a room above, which implements this (core/chain/provisional_chain.hpp).
#pragma once

#include <complex>
#include <span>

#include "core/transient/modal_fit.hpp"

namespace dwell {

// Poles in rad/s, slowest first, of conjugate pairs the one with Im > 0; valid until the next call of seen_by().
class ChainPoles {
 public:
  virtual ~ChainPoles() = default;
  // Of the chain that the steady motion in `fit` tells of; empty: it does not determine a chain. No allocation.
  [[nodiscard]] virtual std::span<const std::complex<double>> seen_by(const ModalFit& fit) noexcept = 0;
  // Of the chain that was identified last; empty: none has been.
  [[nodiscard]] virtual std::span<const std::complex<double>> last() const noexcept = 0;

 protected:
  ChainPoles() = default;
  ChainPoles(const ChainPoles&) = default;
  ChainPoles& operator=(const ChainPoles&) = default;
};

}  // namespace dwell
