#include "tests/study/signal.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "tests/study/random.hpp"
#include "tests/study/recording.hpp"

namespace dwell::study {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Parts of a parameter over which a difference quotient is taken: rounding and curvature both below 1e-5 of it. The
// frequency's is smaller, since the phase at the end turns by all periods times that.
constexpr double kStep = 1e-5, kFrequencyStep = 1e-8;

MassState at_rest(const World& world) {
  const auto n = static_cast<std::size_t>(world.chain.mass_count());
  return {std::vector<double>(n, 0.0), std::vector<double>(n, 0.0)};
}

void add_table(const World& world, const std::vector<ReadingAt>& readings, std::vector<VectorXd>& columns) {
  for (std::size_t h = 0; h < world.table.shape.size(); ++h)
    for (const Complex unit : {Complex{1, 0}, Complex{0, 1}}) {
      World one = world;
      one.state = at_rest(world);
      one.table.shape.assign(world.table.shape.size(), 0.0);
      one.table.shape[h] = unit * std::abs(world.table.shape[0]);
      columns.push_back(signal(one, readings));
    }
  World faster = world, slower = world;
  faster.table.frequency_hz *= 1 + kFrequencyStep;
  slower.table.frequency_hz *= 1 - kFrequencyStep;
  columns.push_back((signal(faster, readings) - signal(slower, readings)) / (2 * kFrequencyStep));
}

void add_state(const World& world, const std::vector<ReadingAt>& readings, std::vector<VectorXd>& columns) {
  const auto n = static_cast<std::size_t>(world.chain.mass_count());
  const double A = std::abs(world.table.shape[0]);
  for (std::size_t k = 0; k < 2 * n; ++k) {
    World one = world;
    one.table.shape.assign(1, 0.0);
    one.state = at_rest(world);
    (k < n ? one.state.y[k] : one.state.velocity[k - n]) = k < n ? A : A * kTwoPi * world.table.frequency_hz;
    columns.push_back(signal(one, readings));
  }
}

}  // namespace

World world_of(const Case& about) {
  return {about.chain, about.sensors, about.side, about.table, about.motion->state(about.change_s), about.change_s};
}

std::vector<ReadingAt> readings_at(const Case& about, double from_s, double until_s, std::size_t most) {
  double total = 0.0;
  for (const Line& line : about.lines) total += line.rate_hz * (until_s - from_s);
  const double part = std::min(1.0, static_cast<double>(most) / std::max(1.0, total));
  std::vector<ReadingAt> out;
  for (int c = 0; c < about.channels(); ++c) {
    const Line& line = about.lines[static_cast<std::size_t>(c)];
    const double weight = 1 / (line.noise() * std::sqrt(part));
    Draws draws(mixed(about.seed) + static_cast<std::uint64_t>(c));
    for (std::int64_t i = 0;; ++i) {
      const double t_s = instant_s(about, c, i);
      if (t_s > until_s) break;
      if (draws.chance(part) && t_s > from_s) out.push_back({c, t_s, weight});
    }
  }
  std::stable_sort(out.begin(), out.end(), [](const ReadingAt& a, const ReadingAt& b) { return a.t_s < b.t_s; });
  return out;
}

VectorXd signal(const World& world, const std::vector<ReadingAt>& readings) {
  Motion motion(world.chain, world.sensors, world.side);
  motion.drive(world.start_s, world.table, world.state);
  VectorXd out(static_cast<Index>(readings.size()));
  for (std::size_t i = 0; i < readings.size(); ++i)
    out(static_cast<Index>(i)) = readings[i].weight * motion.reading(readings[i].channel, readings[i].t_s);
  return out;
}

MatrixXd derivatives(const World& world, const std::vector<ReadingAt>& readings, bool known_start) {
  std::vector<VectorXd> columns;
  for (std::size_t e = 0; e < world.chain.stiffness.size(); ++e)
    for (std::vector<double> Chain::*const of : {&Chain::stiffness, &Chain::damping}) {
      World more = world, less = world;
      (more.chain.*of)[e] *= 1 + kStep;
      (less.chain.*of)[e] *= 1 - kStep;
      columns.push_back((signal(more, readings) - signal(less, readings)) / (2 * kStep));
    }
  add_table(world, readings, columns);
  if (known_start) {
    World earlier = world;
    const double step_s = kStep / world.table.frequency_hz;
    earlier.start_s -= step_s;
    columns.push_back((signal(earlier, readings) - signal(world, readings)) / kStep);
  } else {
    add_state(world, readings, columns);
  }
  MatrixXd out =
      MatrixXd::Zero(static_cast<Index>(readings.size()), static_cast<Index>(columns.size() + world.sensors.size()));
  for (std::size_t j = 0; j < columns.size(); ++j) out.col(static_cast<Index>(j)) = columns[j];
  const auto offsets = static_cast<Index>(columns.size());
  for (std::size_t i = 0; i < readings.size(); ++i)
    out(static_cast<Index>(i), offsets + readings[i].channel) = readings[i].weight;
  return out;
}

double left_of(const VectorXd& column, const MatrixXd& others) {
  // Unit columns, so that the rank is told by directions and not by units.
  const VectorXd size = others.colwise().norm().unaryExpr([](double s) { return s > 0 ? s : 1.0; });
  Eigen::ColPivHouseholderQR<MatrixXd> qr(others * size.cwiseInverse().asDiagonal());
  qr.setThreshold(1e-9);
  return (column - others * size.cwiseInverse().asDiagonal() * qr.solve(column)).norm();
}

VectorXd bound_of(const MatrixXd& derivatives, Index count) {
  // Variances are the diagonal of (R'R)⁻¹, R triangular with the wanted parameters last: only their corner is needed.
  MatrixXd turned(derivatives.rows(), derivatives.cols());
  turned << derivatives.rightCols(derivatives.cols() - count), derivatives.leftCols(count);
  if (turned.rows() < turned.cols()) return VectorXd::Constant(count, INFINITY);
  const VectorXd size = turned.colwise().norm().unaryExpr([](double s) { return s > 0 ? s : 1.0; });
  const Eigen::HouseholderQR<MatrixXd> qr(turned * size.cwiseInverse().asDiagonal());
  const MatrixXd corner = qr.matrixQR().topRows(turned.cols()).bottomRightCorner(count, count);
  const MatrixXd inverse = corner.triangularView<Eigen::Upper>().solve(MatrixXd::Identity(count, count));
  VectorXd out = inverse.rowwise().norm().cwiseQuotient(size.tail(count));
  for (double& u : out)
    if (!std::isfinite(u)) u = INFINITY;
  return out;
}

}  // namespace dwell::study
