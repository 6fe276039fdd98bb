// How far the instants of readings are off, as the residuals show of channels that are read in one transaction.
//
// An instant that is off by δ adds ẏ δ to the residual of every channel of its transaction, ẏ the channel's speed:
// these residuals go together. With z = r/σ and a = ẏ/σ of channels c and d, E z_c z_d = a_c a_d E δ². So
//
//   E δ² = Σ z_c a_c z_d a_d / Σ a_c² a_d² ,
//
// both sums over all instants and all pairs of different channels. The channels' own noise does not bias it.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor.
class SharedInstants {
 public:
  explicit SharedInstants(int channels);

  // Takes the residuals of all the samples in the fit; what was seen before is forgotten. O(samples).
  void look(HoldFit& fit, const HoldNow& now) noexcept;
  // √E δ² of a transaction, s, named as in FittedChannel; 0: no such errors show, or one channel is read alone.
  [[nodiscard]] double u_s(int transaction) const noexcept;

 private:
  struct Transaction {
    // Of the newest instant: sums of z a, (z a)², a², a⁴ over its channels.
    std::int64_t t_ns = std::numeric_limits<std::int64_t>::min();
    double za = 0.0, za2 = 0.0, a2 = 0.0, a4 = 0.0;
    double products = 0.0, squares = 0.0;  // Σ z_c a_c z_d a_d, Σ a_c² a_d² over the instants before
    void end_instant() noexcept;
  };
  struct Newest {
    std::int64_t t_ns = std::numeric_limits<std::int64_t>::min();
    double fitted = 0.0;  // reading, as fitted
  };
  std::vector<Transaction> transactions_;
  std::vector<Newest> newest_;  // per channel
};

}  // namespace dwell
