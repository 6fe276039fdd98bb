#include "tests/study/bound.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "core/forward.hpp"

namespace dwell::study {

std::vector<ElementBound> bounds_of(const Case& about, double seconds) {
  const int n = about.chain.mass_count(), elements = about.chain.element_count(), channels = about.channels();
  const double omega = 2 * std::numbers::pi * about.frequency_hz;
  const bool clamped = about.chain.boundary == Boundary::clamped;

  // Readings in terms of (Y_0, d_1 … d_n[, F]), and back.
  Eigen::MatrixXcd G = Eigen::MatrixXcd::Zero(channels, channels);
  for (int c = 0; c < channels; ++c) {
    const Sensor& sensor = about.sensors[static_cast<std::size_t>(c)];
    Complex factor = sensor.response(about.frequency_hz);
    if (sensor.measures == Quantity::velocity) factor *= Complex{0, omega};
    if (sensor.measures == Quantity::acceleration) factor *= -omega * omega;
    if (sensor.measures == Quantity::force) {
      G(c, n + 1) = factor;
    } else {
      if (!sensor.relative_to) G(c, 0) = factor;
      for (int k = sensor.relative_to.value_or(0) + 1; k <= sensor.at; ++k) G(c, k) = factor;
    }
  }
  const Eigen::MatrixXcd back = G.inverse();
  Eigen::VectorXd sigma(channels);  // of each component of a channel's phasor
  Eigen::VectorXcd X(channels);
  for (int c = 0; c < channels; ++c) {
    const Line& line = about.lines[static_cast<std::size_t>(c)];
    sigma(c) = line.noise() * std::sqrt(2 / (line.rate_hz * seconds));
    X(c) = about.motion->phasor(c, 1);
  }
  const Eigen::VectorXcd x = back * X;

  std::vector<ElementBound> bounds(static_cast<std::size_t>(elements));
  // What the readings do to ω² Σ_{i>=k} m_i Y_i - F.
  Eigen::RowVectorXcd inertia = Eigen::RowVectorXcd::Zero(channels);
  if (clamped) inertia -= back.row(n + 1);
  for (int k = elements; k >= 1; --k) {
    ElementBound& bound = bounds[static_cast<std::size_t>(k - 1)];
    bound.Z = {about.chain.stiffness[static_cast<std::size_t>(k - 1)],
               omega * about.chain.damping[static_cast<std::size_t>(k - 1)]};
    Eigen::RowVectorXcd deformation = Eigen::RowVectorXcd::Zero(channels), force;
    if (k == n + 1) {  // it ends at the ground: its deformation is the last mass's motion
      for (int i = 0; i <= n; ++i) deformation += back.row(i);
      force = back.row(n + 1);
    } else {
      Eigen::RowVectorXcd motion = Eigen::RowVectorXcd::Zero(channels);
      for (int i = 0; i <= k; ++i) motion += back.row(i);
      inertia += omega * omega * about.chain.masses[static_cast<std::size_t>(k - 1)] * motion;
      deformation = back.row(k);
      force = inertia;
    }
    bound.d = (deformation * X)(0);
    bound.sigma_d = deformation.cwiseAbs().transpose().cwiseProduct(sigma).norm();
    bound.sigma_Z =
        ((force - bound.Z * deformation) / bound.d).eval().cwiseAbs().transpose().cwiseProduct(sigma).norm();
  }
  return bounds;
}

}  // namespace dwell::study
