// Detects a step of the drive: a matched filter on the table's channel while its steady motion is known.
//
// Each reading is compared with the prediction by the dwell's fit. Let m(t) be the predicted fundamental and
// q(t) = dm/dφ its quadrature. A drive that has changed by a part α in amplitude and by δω in frequency since t_j has
// the residual r = α m + δω (t - t_j) q. The least squares estimates over the readings since t_j are
//
//   α = Σ r m / Σ m² ,   δω = Σ r q (t - t_j) / Σ q² (t - t_j)² ,   u² = σ² / Σ… + (uncertainty of the fit itself)²
//
// for every t_j on the grid of quarter periods. This is the generalized likelihood ratio test (Basseville and
// Nikiforov, Detection of Abrupt Changes, ch. 2.4.3). It reaches what the noise allows for a step of any size. One
// window of a fixed length sees either large steps soon or small steps at all, not both.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <cstdint>

#include "core/drive/amplitude_excess.hpp"
#include "core/drive/drive_doubt.hpp"
#include "core/drive/residual_blocks.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Bound to one thread; real-time safe except for the constructor.
class StepWatch {
 public:
  // tolerance: relative change of amplitude or frequency; beyond 1.5 times as much it is another drive.
  explicit StepWatch(double tolerance) : tolerance_(tolerance) {}

  // The readings to expect while the drive has not changed, SI. sigma: standard deviation of a reading. u_amplitude
  // (relative), u_phase (rad, at t_ref) and u_omega (rad/s): standard uncertainties.
  struct Reference {
    std::int64_t t_ref_ns;
    double mean;
    std::array<std::complex<double>, kMaxHarmonics> X;  // phasors of harmonics 1 … at t_ref
    int harmonics;
    double omega, drift;  // rad/s at t_ref, and its rate, rad/s²
    double sigma, u_amplitude, u_phase, u_omega;
    double u_rounding;  // relative standard uncertainty of an amplitude by rounding that repeats with the motion
  };
  // beats: hum may beat with the drive in this channel. The limit of amplitude is then one tolerance higher.
  void expect_beats(bool beats) noexcept { beats_ = beats ? 1.0 : 0.0; }
  void restart() noexcept;
  // Takes a better reference and converts the sums so far to it.
  void refer(const Reference& reference) noexcept;
  // Takes one reading. extra_u_s: by how much its instant is less certain than usual. Costs a polynomial for
  // sine and cosine, and a few times a period a call of libm. Does nothing before the first reference.
  void add(std::int64_t t_ns, double value, double extra_u_s = 0.0) noexcept;
  // Ends a quarter of a period. True: the drive differs from the reference. O(ResidualBlocks::kLongest).
  [[nodiscard]] bool close() noexcept;

  // Quarter periods since the drive agreed with the reference beyond doubt; 0: it does now.
  [[nodiscard]] int since_good() const noexcept { return since_good_; }
  // extra_u_s of the readings in the newest period, rms.
  [[nodiscard]] double extra_u_s() const noexcept { return extra_u_s_; }
  // Whether enough quarters are seen to tell a step.
  [[nodiscard]] bool watches() const noexcept { return blocks_.seen() >= kShortest; }

 private:
  static constexpr int kShortest = 6;  // quarter periods of the shortest stretch: one disturbed reading is no step

  // The change since an instant: relative, of amplitude (alpha); of ω, rad/s (drift); with their variances.
  struct Change {
    double since_s;
    double alpha, u2_alpha, drift, u2_drift;
    double extra_u2;  // mean square of extra_u_s as a phase, rad²
  };
  [[nodiscard]] std::complex<double> turn_at(double t_s) noexcept;
  [[nodiscard]] Change change_since(const ResidualsSince& sums, double since_s, double now_s) const noexcept;
  [[nodiscard]] double weigh(const Change& change, bool far_back) noexcept;
  [[nodiscard]] int changed() const noexcept;

  double tolerance_;
  ResidualBlocks blocks_;
  bool referred_ = false;
  Reference now_{};
  double amplitude_ = 0.0;  // of its fundamental
  // The newest reading whose turn libm computed: the turns of the next ones follow from it.
  struct {
    double t_s = NAN;           // NaN: none since the reference
    std::complex<double> turn;  // exp(jφ) at t_s
  } near_;
  AmplitudeExcess excess_;
  DriveDoubt doubt_;
  double beats_ = 0.0, extra_u_s_ = 0.0;
  int since_good_ = 0;
};

}  // namespace dwell
