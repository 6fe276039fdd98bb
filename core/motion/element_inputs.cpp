#include "core/motion/element_inputs.hpp"

#include <algorithm>
#include <cmath>

namespace dwell {
namespace {

using Eigen::VectorXd;

// Of the rate's rms: within it friction goes over from one sign to the other. Beside the step of the rate from reading
// to reading, a tenth of its amplitude at 60 readings a period, it is small; without it a rig at rest would have a
// friction of any sign.
constexpr double kSticks = 0.02;

// One element's deformation and its rate, or a mass's velocity alone: just after the reading before, and as predicted
// for this one.
struct DeformationCourse {
  std::vector<double> d_before, d_now, v_before, v_now;
};

// v/√(v² + w²) and its mean over a stretch in which v goes evenly from a to b.
double direction(double v, double w) { return v / std::hypot(v, w); }
double mean_direction(double a, double b, double w) {
  if (std::abs(b - a) < 1e-3 * w) return direction(0.5 * (a + b), w);
  return (std::hypot(b, w) - std::hypot(a, w)) / (b - a);
}

MotionInput friction(const DeformationCourse& of) {
  double squares = 0.0;
  for (const double v : of.v_now) squares += v * v;
  const double w = std::max(kSticks * std::sqrt(squares / static_cast<double>(of.v_now.size())), 1e-300);
  MotionInput out;
  for (std::size_t i = 0; i < of.v_now.size(); ++i) {
    out.mean.push_back(mean_direction(of.v_before[i], of.v_now[i], w));
    out.now.push_back(direction(of.v_now[i], w));
  }
  return out;
}

// About the mean deformation, which the biases do not tell. Simpson's rule with the middle of a cubic.
MotionInput cube(const DeformationCourse& of, const MotionData& data) {
  double mean = 0.0;
  for (const double d : of.d_now) mean += d / static_cast<double>(of.d_now.size());
  const auto third = [mean](double d) { return std::pow(d - mean, 3); };
  MotionInput out;
  for (std::size_t i = 0; i < of.d_now.size(); ++i) {
    const double dt_s = i == 0 ? 0.0 : 1e-9 * static_cast<double>(data.readings[i].t_ns - data.readings[i - 1].t_ns);
    const double middle = 0.5 * (of.d_before[i] + of.d_now[i]) + 0.125 * dt_s * (of.v_before[i] - of.v_now[i]);
    out.mean.push_back((third(of.d_before[i]) + 4 * third(middle) + third(of.d_now[i])) / 6);
    out.now.push_back(third(of.d_now[i]));
  }
  return out;
}

}  // namespace

std::vector<MotionInput> element_inputs(const MotionModel& model, const MotionData& data, const MotionUnknowns& at,
                                        const std::vector<Parameter>& wanted) {
  std::vector<MotionInput> out;
  if (wanted.empty()) return out;
  const int elements = model.rig().element_count(), masses = model.rig().mass_count();
  Eigen::MatrixXd rows(2 * elements + masses, model.states());
  for (int k = 1; k <= elements; ++k) {
    rows.row(k - 1) = model.deformation_row(k);
    rows.row(elements + k - 1) = model.rate_row(k);
  }
  for (int k = 1; k <= masses; ++k) rows.row(2 * elements + k - 1) = model.velocity_row(k);
  std::vector<DeformationCourse> courses(
      static_cast<std::size_t>(elements + masses));  // of the elements, then of the masses
  PassOptions options{.derivatives = false};
  options.show = [&](const VectorXd& before, const VectorXd& predicted) {
    const VectorXd then = rows * before, now = rows * predicted;
    for (int e = 0; e < elements; ++e) {
      DeformationCourse& course = courses[static_cast<std::size_t>(e)];
      course.d_before.push_back(then(e));
      course.d_now.push_back(now(e));
      course.v_before.push_back(then(elements + e));
      course.v_now.push_back(now(elements + e));
    }
    for (int k = 0; k < masses; ++k) {
      DeformationCourse& course = courses[static_cast<std::size_t>(elements + k)];
      course.v_before.push_back(then(2 * elements + k));
      course.v_now.push_back(now(2 * elements + k));
    }
  };
  (void)evaluate(model, data, at, options);
  for (const Parameter& p : wanted) {
    DeformationCourse& course =
        courses[static_cast<std::size_t>(p.what == Unknown::ground_friction ? elements + p.index : p.index)];
    for (std::vector<double>* of : {&course.d_before, &course.d_now, &course.v_before, &course.v_now})
      of->resize(data.readings.size(), 0.0);  // where the pass ended early
    out.push_back(p.what == Unknown::cubic ? cube(course, data) : friction(course));
  }
  return out;
}

}  // namespace dwell
