// Has the drive stepped? A matched filter on the table's channel while its steady motion is known.
//
// Each reading is compared with what the dwell's fit predicts. With m(t) the predicted fundamental and q(t) = dm/dφ its
// quadrature, the residual r of a drive that has changed by a part α in amplitude and by δω in frequency since t_j is
// α m + δω (t - t_j) q, so that over the readings since t_j
//
//   α = Σ r m / Σ m² ,   δω = Σ r q (t - t_j) / Σ q² (t - t_j)² ,   u² = σ² (1 / Σ… + what the fit itself does not
//   know)
//
// are the least squares estimates, for every t_j on the grid of quarter periods: the generalized likelihood ratio test
// (Basseville and Nikiforov, Detection of Abrupt Changes, ch. 2.4.3), which reaches what the noise allows for a step of
// any size, where one window of a fixed length sees either the large ones soon or the small ones at all.
#pragma once

#include <array>
#include <complex>
#include <cstdint>

#include "core/drive/amplitude_excess.hpp"
#include "core/drive/drive_doubt.hpp"
#include "core/drive/residual_blocks.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Bound to one thread, real-time safe but for the constructor.
class StepWatch {
 public:
  static constexpr int kLongest = ResidualBlocks::kLongest;  // quarter periods that are gone back

  // tolerance: relative change of amplitude or frequency that is another drive.
  explicit StepWatch(double tolerance) : tolerance_(tolerance) {}

  // The readings to expect while the drive has not changed: mean, phasors of harmonics 1 … at t_ref (SI of the reading,
  // rad), omega (rad/s), the standard deviation of a reading, and how well that is known: relative standard uncertainty
  // of the amplitude, of the phase at t_ref (rad) and of omega (rad/s).
  struct Reference {
    std::int64_t t_ref_ns;
    double mean;
    std::array<std::complex<double>, kMaxHarmonics> X;
    int harmonics;
    double omega, drift;  // rad/s at t_ref, and its rate, rad/s²
    double sigma, u_amplitude, u_phase, u_omega;
    double u_rounding;  // relative, of an amplitude, by rounding that repeats with the motion
  };
  // beats: whether hum may beat with the drive in this channel; then a tolerance is left to it.
  void expect_beats(bool beats) noexcept { beats_ = beats ? 1.0 : 0.0; }
  void restart() noexcept;
  // Takes a better reference; what was seen before is brought to it.
  void refer(const Reference& reference) noexcept;
  // One reading; late_s: by how much its instant is less certain than usual. One sine and cosine; nothing before the
  // first reference.
  void add(std::int64_t t_ns, double value, double late_s = 0.0) noexcept;
  // Ends a quarter of a period. Whether the drive is another than the reference. O(kLongest).
  [[nodiscard]] bool close() noexcept;

  // Quarter periods since the drive was last beyond doubt as the reference says; 0: now.
  [[nodiscard]] int since_good() const noexcept { return since_good_; }
  // How late the readings of the newest period were, beyond the usual: rms, s.
  [[nodiscard]] double late_s() const noexcept { return late_s_; }
  // Enough is seen for a verdict.
  [[nodiscard]] bool watches() const noexcept { return blocks_.seen() >= kShortest; }

 private:
  static constexpr int kShortest = 6;  // quarter periods: one disturbed reading is no step

  // What the readings since an instant say: relative change of amplitude and change of ω, rad/s, with their variances.
  struct Change {
    double since_s;
    double alpha, u2_alpha, drift, u2_drift;
    double late2;  // mean square of how late they were, rad²
  };
  [[nodiscard]] Change change_since(const ResidualsSince& sums, double since_s, double now_s) const noexcept;
  [[nodiscard]] double weigh(const Change& change, bool far_back) noexcept;
  [[nodiscard]] int changed() const noexcept;

  double tolerance_;
  ResidualBlocks blocks_;
  bool referred_ = false;
  Reference now_{};
  double amplitude_ = 0.0;  // of its fundamental
  AmplitudeExcess excess_;
  DriveDoubt doubt_;
  double beats_ = 0.0, late_s_ = 0.0;
  int since_good_ = 0;
};

}  // namespace dwell
