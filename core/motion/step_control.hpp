// How far a step of a Gauss-Newton search goes: Levenberg's damping, and twice as far where the function proves flatter
// than the information says. It learns from what each step gained.
//
// In a narrow curved valley (two stiffnesses that few readings tell apart) one damping overshoots, and ten times that
// damping creeps: the next damping then lies between the two. And where an intensity or a noise falls towards zero, the
// likelihood is flatter than its information says, up to twenty times in a healthy dwell, so that plain steps creep for
// all the passes that a search has.
#pragma once

namespace dwell {

// Bound to one thread. Real-time safe.
class StepControl {
 public:
  // Levenberg's, of an information scaled to a unit diagonal.
  [[nodiscard]] double damping() const noexcept { return damping_; }
  // Factor on the damped step: 1 or 2.
  [[nodiscard]] double factor() const noexcept { return factor_; }
  // The damping has reached 1e6: for long even short steps have gained too little.
  [[nodiscard]] bool spent() const noexcept;

  // What the step gained: by how much the function fell, over ½ |gᵀs| of the damped step s without the factor. Where
  // the information is the curvature, an undamped step has 1; damping raises that towards 2, so that a damping above 1
  // counts as flat too. Negative: the function rose. NaN counts as no gain.
  void learn(double gain) noexcept;

 private:
  void damp(double gain) noexcept;

  static constexpr double kLeastDamping = 1e-9;
  double damping_ = kLeastDamping;
  double served_ = 0.0;  // the damping of the last step that gained more than kPoor
  int poor_ = 0;         // steps in a row that gained less, taken or not
  double factor_ = 1.0;
  bool flat_ = false;  // the last step found the function flatter
};

}  // namespace dwell
