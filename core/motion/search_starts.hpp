// Where the search for the largest likelihood of a motion begins. The likelihood has lesser maxima, in which noise
// stands for motion, and valleys in which a search comes to no end. So a fit is searched from several starts, and the
// lowest V is kept.
//
// First readings: the coefficients of the weak form, with a small intensity of the table; the same with a large one. If
// more than noise is left, also H2, the coefficients of the weak form divided by its coherence.
// More readings: the end of the fit before. If that search comes to no end, also the coefficients of the weak form.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/motion/motion_fit.hpp"
#include "core/motion/weak_form.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Bound to one thread; the rig must outlive it. A fit allocates, may not have converged, and counts the passes of all
// its starts. Throws Stopped as fit_motion() does.
class SearchStarts {
 public:
  explicit SearchStarts(const Rig& rig) : rig_(rig) {}

  // The table's next stretch, in which it moves with that amplitude, m.
  void add_stretch(double amplitude);
  void take_weak_form(const WeakForm& weak);

  [[nodiscard]] int stretches() const noexcept { return static_cast<int>(ln_q_.size()); }
  // Logarithm of the intensity that a stretch begins with.
  [[nodiscard]] double ln_q(int stretch) const { return ln_q_[static_cast<std::size_t>(stretch)]; }
  // (c_1, r_1, c_2, …) of the weak form; 10 % of damping at the drive's frequency where it has none.
  [[nodiscard]] const Eigen::VectorXd& coefficients() const noexcept { return coefficients_; }

  // noise: of each channel from reading to reading, SI.
  [[nodiscard]] MotionFit first(const MotionModel& model, const MotionData& data, const MotionUnknowns& at,
                                const FitLimits& limits, const std::vector<double>& noise) const;
  // at: the end of a fit to the readings up to fitted_ns.
  [[nodiscard]] MotionFit longer(const MotionModel& model, const MotionData& data, const MotionUnknowns& at,
                                 const FitLimits& limits, std::int64_t fitted_ns) const;

 private:
  [[nodiscard]] MotionUnknowns with_newest_again(const MotionModel& model, const MotionData& data,
                                                 const MotionUnknowns& at, std::int64_t fitted_ns) const;
  [[nodiscard]] MotionUnknowns with_coefficients(MotionUnknowns at, const Eigen::VectorXd& coefficients) const;

  const Rig& rig_;
  std::vector<double> ln_q_;                // by stretch
  Eigen::VectorXd coefficients_, largest_;  // of the weak form; divided by its coherence
};

}  // namespace dwell
