// How far a step of a Gauss-Newton search goes: Levenberg's damping, and twice as far where the function proves flatter
// than the information says. It learns from what each step gained.
//
// Why both: in a narrow curved valley, as of two stiffnesses that few readings tell apart, one damping goes too far and
// ten times as much creeps, so that a refused step is followed by one between the two. And where an intensity or a
// noise falls towards zero, the likelihood is up to twenty times flatter than its information, and steps of scoring
// creep for all the passes that a search has.
#pragma once

namespace dwell {

class Stride {
 public:
  // Levenberg's, of an information scaled to a unit diagonal.
  [[nodiscard]] double damping() const noexcept { return damping_; }
  // The damped step is to be taken so many times: 1 or 2.
  [[nodiscard]] double stretch() const noexcept { return stretch_; }
  // No step gains any more, however short.
  [[nodiscard]] bool spent() const noexcept;

  // gain: by how much the function fell, over what the damped step s, not stretched, promised: -½ gᵀs. It is 1 where
  // the information is the curvature, and negative where the function rose. A gain that is no number counts as none.
  void learn(double gain) noexcept;

 private:
  void damp(double gain) noexcept;

  static constexpr double kLeastDamping = 1e-9;
  double damping_ = kLeastDamping;
  double served_ = 0.0;  // the last damping whose step gained
  int poor_ = 0;         // steps in a row that did not
  double stretch_ = 1.0;
  bool flat_ = false;  // the step before said so
};

}  // namespace dwell
