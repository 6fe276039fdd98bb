#include "core/drive/frequency_search.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/instants.hpp"
#include "core/drive/refine.hpp"
#include "core/result/dwell.hpp"

namespace dwell {
namespace {

// Cost of one reading, in multiplications: in one cell, and where it needs a sine and a cosine.
constexpr double kOfCell = 12.0, kOfSine = 100.0;

}  // namespace

FrequencySearch::FrequencySearch(const Rig& rig)
    : low_(kTwoPi * rig.excitation.search_low_hz),
      high_(kTwoPi * rig.excitation.search_high_hz),
      longest_s_(kTwoPi / low_),
      width_(high_ - low_) {
  if (rig.excitation.reference == Reference::fixed || !(low_ > 0) || !(high_ > low_)) return;
  const double cells = std::ceil((high_ - low_) / (0.5 * low_));
  cells_.resize(static_cast<std::size_t>(cells));
  width_ = (high_ - low_) / cells;
}

bool FrequencySearch::near(double omega, double other) const noexcept {
  return std::abs(omega - other) <= 0.5 * width_;
}

template <class Use>
void FrequencySearch::Readings::each(Use&& use) const noexcept {
  double reference = kNaN;
  for (std::uint64_t i = first; i < last; ++i) {
    const SampleHistory::Sample& sample = history[i];
    if (sample.channel != channel) continue;
    if (std::isnan(reference)) reference = sample.value;
    use(to_s(sample.t_ns - centre_ns), sample.value - reference);
  }
}

// Centre of the cell in which a sine beside a mean explains most of the readings.
double FrequencySearch::best_cell(const Readings& readings) noexcept {
  std::fill(cells_.begin(), cells_.end(), Cell{});
  double n = 0.0, y_sum = 0.0;
  const double lowest = low_ + 0.5 * width_;
  readings.each([&](double u, double y) {
    n += 1.0;
    y_sum += y;
    double s = std::sin(lowest * u), c = std::cos(lowest * u);
    const double by_s = std::sin(width_ * u), by_c = std::cos(width_ * u);
    for (Cell& cell : cells_) {
      cell.s += s;
      cell.c += c;
      cell.ss += s * s;
      cell.sc += s * c;
      cell.cc += c * c;
      cell.ys += y * s;
      cell.yc += y * c;
      const double next = s * by_c + c * by_s;
      c = c * by_c - s * by_s;
      s = next;
    }
  });
  readings.history.spend(n * (2 * kOfSine + kOfCell * static_cast<double>(cells_.size())));
  double most = 0.0, best = lowest;
  for (std::size_t i = 0; i < cells_.size(); ++i) {
    const Cell& cell = cells_[i];
    // Centred: sums about the means.
    const double ss = cell.ss - cell.s * cell.s / n, sc = cell.sc - cell.s * cell.c / n,
                 cc = cell.cc - cell.c * cell.c / n;
    const double ys = cell.ys - cell.s * y_sum / n, yc = cell.yc - cell.c * y_sum / n;
    const double explained = (cc * ys * ys - 2 * sc * ys * yc + ss * yc * yc) / (ss * cc - sc * sc);
    if (!(explained > most)) continue;
    most = explained;
    best = lowest + static_cast<double>(i) * width_;
  }
  return best;
}

std::optional<double> FrequencySearch::refined(const Readings& readings, double omega) const noexcept {
  bool sure = false;
  for (int step = 0; step < kMostSteps; ++step) {
    // Products of 1, sin, cos, u sin, u cos and y. With b, p, q fitted, the derivative by ω is p u cos - q u sin.
    Eigen::Matrix<double, 6, 6> G = Eigen::Matrix<double, 6, 6>::Zero();
    readings.each([&](double u, double y) {
      const double s = std::sin(omega * u), c = std::cos(omega * u);
      const Eigen::Matrix<double, 6, 1> x{1.0, s, c, u * s, u * c, y};
      G.noalias() += x * x.transpose();
    });
    const double n = G(0, 0);
    readings.history.spend(n * (kOfSine + 36));
    const Eigen::LLT<Eigen::Matrix3d> llt(G.topLeftCorner<3, 3>());
    if (llt.info() != Eigen::Success || n < 6) return {};
    const Eigen::Vector3d theta = llt.solve(G.col(5).head<3>());
    const double squares = G(5, 5) - theta.dot(G.col(5).head<3>());
    const double sigma2 = std::max(squares, 1e-15 * G(5, 5)) / (n - 4);
    const Eigen::Vector3d gX = theta(1) * G.col(4).head<3>() - theta(2) * G.col(3).head<3>();
    const double gg = theta(1) * theta(1) * G(4, 4) - 2 * theta(1) * theta(2) * G(3, 4) + theta(2) * theta(2) * G(3, 3);
    const double gy = theta(1) * G(4, 5) - theta(2) * G(3, 5);
    const double information = gg - gX.dot(llt.solve(gX)), score = gy - gX.dot(theta);
    const Eigen::Matrix3d covariance = sigma2 * llt.solve(Eigen::Matrix3d::Identity());
    // At this amplitude ω is known to 0.11/T, less than half a cell.
    sure = theta.tail<2>().squaredNorm() > sigmas::kSure * sigmas::kSure * 0.5 * (covariance(1, 1) + covariance(2, 2));
    if (!(information > 0)) return {};
    const double next = std::clamp(omega + score / information, low_, high_);
    const bool found = std::abs(next - omega) < kNegligibleStep * std::sqrt(sigma2 / information);
    omega = next;
    if (found) break;
  }
  return sure ? std::optional(omega) : std::nullopt;
}

std::optional<double> FrequencySearch::find(const SampleHistory& history, int channel, std::int64_t begin_ns,
                                            std::int64_t end_ns) noexcept {
  if (to_s(end_ns - begin_ns) < 0.5 * longest_s_) return {};
  const Readings readings{history, channel, history.first_at(begin_ns), history.first_at(end_ns),
                          begin_ns + (end_ns - begin_ns) / 2};
  return refined(readings, best_cell(readings));
}

}  // namespace dwell
