#include "tests/study/bound.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "core/forward.hpp"

namespace dwell::study {

namespace {

// What the readings' phasors say of force and deformation of each element: f = force X, d = deformation X, Z = f / d.
struct Rows {
  Eigen::MatrixXcd force, deformation;  // elements × channels
};

// masses: true or stated; with_response: the transducers' own gain, delay and filter divided out.
Rows rows_of(const Case& about, const std::vector<double>& masses, double omega, bool with_response) {
  const int n = about.chain.mass_count(), elements = about.chain.element_count(), channels = about.channels();
  const bool clamped = about.chain.boundary == Boundary::clamped;
  // Readings in terms of (Y_0, d_1 … d_n[, F]), and back.
  Eigen::MatrixXcd G = Eigen::MatrixXcd::Zero(channels, channels);
  for (int c = 0; c < channels; ++c) {
    const Sensor& sensor = about.sensors[static_cast<std::size_t>(c)];
    Complex factor = with_response ? sensor.response(omega / (2 * std::numbers::pi)) : Complex{1.0};
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
  Rows rows{Eigen::MatrixXcd(elements, channels), Eigen::MatrixXcd(elements, channels)};
  Eigen::RowVectorXcd inertia = Eigen::RowVectorXcd::Zero(channels);  // ω² Σ_{i>=k} m_i Y_i - F
  if (clamped) inertia -= back.row(n + 1);
  for (int k = elements; k >= 1; --k) {
    if (k == n + 1) {  // it ends at the ground: its deformation is the last mass's motion
      rows.deformation.row(k - 1) = back.topRows(n + 1).colwise().sum();
      rows.force.row(k - 1) = back.row(n + 1);
    } else {
      inertia += omega * omega * masses[static_cast<std::size_t>(k - 1)] * back.topRows(k + 1).colwise().sum();
      rows.deformation.row(k - 1) = back.row(k);
      rows.force.row(k - 1) = inertia;
    }
  }
  return rows;
}

}  // namespace

std::vector<ElementBound> bounds_of(const Case& about, double seconds) {
  const int channels = about.channels();
  const double omega = 2 * std::numbers::pi * about.frequency_hz;
  const Rows rows = rows_of(about, about.chain.masses, omega, true);
  Eigen::VectorXd sigma(channels);  // of each component of a channel's phasor
  Eigen::VectorXcd X(channels);
  for (int c = 0; c < channels; ++c) {
    const Line& line = about.lines[static_cast<std::size_t>(c)];
    sigma(c) = line.noise() * std::sqrt(2 / (line.rate_hz * seconds));
    X(c) = about.motion->phasor(c, 1);
  }
  std::vector<ElementBound> bounds;
  for (Eigen::Index e = 0; e < rows.force.rows(); ++e) {
    const auto i = static_cast<std::size_t>(e);
    ElementBound bound;
    bound.Z = {about.chain.stiffness[i], omega * about.chain.damping[i]};
    bound.d = (rows.deformation.row(e) * X)(0);
    bound.sigma_d = rows.deformation.row(e).cwiseAbs().transpose().cwiseProduct(sigma).norm();
    const Eigen::RowVectorXcd to_Z = (rows.force.row(e) - bound.Z * rows.deformation.row(e)) / bound.d;
    bound.sigma_Z = to_Z.cwiseAbs().transpose().cwiseProduct(sigma).norm();
    bounds.push_back(bound);
  }
  return bounds;
}

std::vector<Complex> stiffness_of(const Case& about, double omega, const std::vector<Complex>& X) {
  const Rows rows = rows_of(about, about.rig.masses, omega, false);
  const Eigen::Map<const Eigen::VectorXcd> readings(X.data(), static_cast<Eigen::Index>(X.size()));
  std::vector<Complex> Z;
  for (Eigen::Index e = 0; e < rows.force.rows(); ++e)
    Z.push_back((rows.force.row(e) * readings)(0) / (rows.deformation.row(e) * readings)(0));
  return Z;
}

}  // namespace dwell::study
