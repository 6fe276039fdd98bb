// Fits a hold anew: chooses where the fit begins and which poles explain the data.
//
// Four sources of poles are tried in turn until one explains the data: the poles believed so far; the chain as now
// identified; the same chain without the poles found beside it; the chain identified from the latest third of the hold.
// After a knock the motion since is fitted by itself. Where nothing explains the data, the next fit begins later.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transient/chain_poles.hpp"
#include "core/transient/foreign_lines.hpp"
#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/knock_watch.hpp"
#include "core/transient/pole_search.hpp"
#include "core/transient/residual_noise.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor.
class HoldRefit {
 public:
  // The parts that it works on; all must outlive it.
  struct Parts {
    ChainPoles& chain;
    HoldFit& fit;
    ResidualNoise& noise;
    KnockWatch& knocks;
    PoleSearch& search;
    ForeignLines& lines;
  };
  HoldRefit(const Parts& parts, std::size_t masses);

  void begin_hold() noexcept { skipped_ = 0.0; }
  // Whether there are poles to start from.
  [[nodiscard]] bool possible() const noexcept;
  // Fits the hold anew and believes the new poles. seen: the frequency that the drive's channel shows by itself.
  // Returns false if no poles could be fitted. Cost: fit.affordable() fits and a few more.
  bool make(const SeenFrequency& seen, const HoldNow& now);

 private:
  enum class Source { believed, chain, chain_alone, latest_third };
  // The best poles tried so far.
  struct Kept {
    std::vector<std::complex<double>> poles, beside;
    double omega = 0.0;        // of the drive, rad/s
    double misfit = INFINITY;  // with a penalty for each pole beside the chain
  };
  [[nodiscard]] bool explained(const HoldNow& now) const noexcept {
    return parts_.noise.explained(parts_.fit.fit(), now);
  }
  void place_begin(const HoldNow& now) noexcept;
  // Puts the poles of that source into search.best(); false: it has none.
  bool set_up(Source source, bool fitted, double omega, const HoldNow& now);
  // Keeps the present fit if it is better than all before. Returns whether it is.
  bool keep_if_better(double misfit);
  void renew_silent_poles();
  bool explain_since_knock(double omega, const HoldNow& now);
  bool fit_since_knock(double omega, std::int64_t first_ns, const HoldNow& now);
  void finish(const HoldNow& now);

  Parts parts_;
  Kept kept_;
  std::vector<std::complex<double>> beside_before_;  // poles beside the chain, before this refit
  std::vector<std::complex<double>> known_;          // poles known, for a fit after a knock
  double skipped_ = 0.0;                             // part of the hold that the next fit leaves out
};

}  // namespace dwell
