#include "tests/study/bound.hpp"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "core/model/forward.hpp"

namespace dwell::study {

namespace {

// The true rig: masses and transducers with their gain, delay and filter; or the rig as stated, without any of these.
ElementRows rows_of(const Case& about, double omega, bool truly) {
  const std::vector<double>& masses = truly ? about.chain.masses : about.rig.masses;
  const int n = about.chain.mass_count(), elements = about.chain.element_count(), channels = about.channels();
  const bool clamped = about.chain.boundary == Boundary::clamped;
  // Readings in terms of (Y_0, d_1 … d_n[, F]), and back.
  Eigen::MatrixXcd G = Eigen::MatrixXcd::Zero(channels, channels);
  for (int c = 0; c < channels; ++c) {
    Sensor sensor = about.sensors[static_cast<std::size_t>(c)];
    if (!truly) {
      const Channel& stated = about.rig.channels[static_cast<std::size_t>(c)];
      sensor = {stated.measures, stated.at, stated.relative_to, 1.0, 0.0, {}};
    }
    Complex factor = sensor.response({0.0, omega});
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
  ElementRows rows{Eigen::MatrixXcd(elements, channels), Eigen::MatrixXcd(elements, channels)};
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

ElementRows true_rows(const Case& about, double omega) { return rows_of(about, omega, true); }

std::vector<ElementBound> bounds_of(const Case& about, double seconds) {
  const int channels = about.channels();
  const double omega = 2 * std::numbers::pi * about.frequency_hz;
  const ElementRows rows = true_rows(about, omega);
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
  const ElementRows by = rows_of(about, omega, false);
  const Eigen::Map<const Eigen::VectorXcd> readings(X.data(), static_cast<Eigen::Index>(X.size()));
  std::vector<Complex> Z;
  for (Eigen::Index e = 0; e < by.force.rows(); ++e)
    Z.push_back((by.force.row(e) * readings)(0) / (by.deformation.row(e) * readings)(0));
  return Z;
}

}  // namespace dwell::study
