#include "core/motion/weak_form.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPower = 6;   // of 1 - u²: derivatives up to the fifth vanish at the ends
constexpr int kOrders = 5;  // χ … χ''''

// Coefficients of χ and its derivatives by u, powers of u from 0.
class TestFunction {
 public:
  TestFunction() {
    std::array<double, kSize> now{};
    now[0] = 1.0;
    for (int i = 0; i < kPower; ++i)  // times 1 - u²
      for (int k = kSize - 1; k >= 2; --k) now[static_cast<std::size_t>(k)] -= now[static_cast<std::size_t>(k - 2)];
    for (auto& row : coefficients_) {
      row = now;
      for (std::size_t k = 0; k + 1 < kSize; ++k) now[k] = static_cast<double>(k + 1) * now[k + 1];
      now[kSize - 1] = 0.0;
    }
  }
  // The p-th derivative by u.
  [[nodiscard]] double operator()(int p, double u) const {
    double sum = 0.0;
    const auto& row = coefficients_[static_cast<std::size_t>(p)];
    for (std::size_t k = kSize; k-- > 0;) sum = sum * u + row[k];
    return sum;
  }

 private:
  static constexpr int kSize = 2 * kPower + 1;
  std::array<std::array<double, kSize>, kOrders> coefficients_{};
};

// The readings of one channel, its phase at the drive taken for a delay, in SI of what it observes.
struct Series {
  std::vector<double> t_s, value;
  int derivative = 0;

  // The cubic through the readings i-1 … i+2, at t between i and i+1.
  [[nodiscard]] double at(std::size_t i, double t) const {
    const std::size_t first = std::min(std::max<std::size_t>(i, 1) - 1, t_s.size() - 4);
    double sum = 0.0;
    for (std::size_t a = first; a < first + 4; ++a) {
      double part = value[a];
      for (std::size_t b = first; b < first + 4; ++b)
        if (b != a) part *= (t - t_s[b]) / (t_s[a] - t_s[b]);
      sum += part;
    }
    return sum;
  }

  // ∫χ^(p) y dt for p = 2, 3, 4 over [middle - half, middle + half], derivatives by t.
  [[nodiscard]] Eigen::Vector3d integrals(const TestFunction& chi, double middle, double half) const {
    static const std::array<double, 3> nodes{-std::sqrt(0.6), 0.0, std::sqrt(0.6)}, weights{5.0 / 9, 8.0 / 9, 5.0 / 9};
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    auto i = static_cast<std::size_t>(std::upper_bound(t_s.begin(), t_s.end(), middle - half) - t_s.begin());
    for (i = std::max<std::size_t>(i, 1) - 1; i + 1 < t_s.size() && t_s[i] < middle + half; ++i) {
      const double from = std::max(t_s[i], middle - half), to = std::min(t_s[i + 1], middle + half);
      for (std::size_t g = 0; g < 3; ++g) {
        const double t = 0.5 * (from + to) + 0.5 * (to - from) * nodes[g], y = at(i, t);
        for (int p = 2; p <= 4; ++p)
          sum(p - 2) += 0.5 * (to - from) * weights[g] * y * chi(p - derivative, (t - middle) / half);
      }
    }
    const double sign = derivative == 1 ? -1.0 : 1.0;
    for (int p = 2; p <= 4; ++p) sum(p - 2) *= sign / std::pow(half, p - derivative);
    return sum;
  }
};

std::vector<Series> series_of(const Rig& rig, const MotionData& data) {
  std::vector<Series> all(rig.channels.size());
  const double f = rig.excitation.frequency_hz;
  std::vector<double> late(all.size()), size(all.size());
  for (std::size_t c = 0; c < all.size(); ++c) {
    const Channel& channel = rig.channels[c];
    const std::complex<double> H =
        filter_response(channel.lowpass, false, f) * filter_response(channel.highpass, true, f);
    late[c] = -std::arg(H) / (kTwoPi * f);
    size[c] = std::abs(H) * (channel.force_on_mass ? -1.0 : 1.0);
    all[c].derivative = derivative_order(channel.measures);
  }
  for (const MotionReading& reading : data.readings) {
    const auto c = static_cast<std::size_t>(reading.channel);
    const double t = to_s(reading.t_ns) - late[c];
    if (!all[c].t_s.empty() && t <= all[c].t_s.back()) continue;
    all[c].t_s.push_back(t);
    all[c].value.push_back(reading.value / size[c]);
  }
  return all;
}

// Rows of one window: (Y_0, d_1 … d_n, F) under χ'', χ''' and χ''''.
MatrixXd window(const std::vector<Series>& all, const MatrixXd& gain, const TestFunction& chi, double middle,
                double half) {
  MatrixXd observed = MatrixXd::Zero(gain.cols(), 3);
  for (Index c = 0; c < gain.cols(); ++c)
    if (!gain.col(c).isZero(0.0))
      observed.row(c) = all[static_cast<std::size_t>(c)].integrals(chi, middle, half).transpose();
  return gain * observed;
}

}  // namespace

WeakForm weak_form(const Rig& rig, const MotionData& data) {
  const int n = rig.mass_count(), elements = rig.element_count();
  WeakForm out;
  out.stiffness = out.damping = VectorXd::Constant(elements, std::numeric_limits<double>::quiet_NaN());
  const std::vector<Series> all = series_of(rig, data);
  VectorXd weights = VectorXd::Zero(static_cast<Index>(all.size()));
  double from = -1e300, to = 1e300;
  for (std::size_t c = 0; c < all.size(); ++c) {
    if (rig.channels[c].measures == Quantity::auxiliary) continue;
    if (all[c].t_s.size() < 8) return out;
    double squares = 0.0;
    for (const double v : all[c].value) squares += v * v;
    weights(static_cast<Index>(c)) =
        1.0 / std::max(std::sqrt(squares / static_cast<double>(all[c].value.size())), 1e-300);
    from = std::max(from, all[c].t_s.front());
    to = std::min(to, all[c].t_s.back());
  }
  MatrixXd G = observation_matrix(rig);
  if (rig.boundary == Boundary::free) G.conservativeResize(Eigen::NoChange, n + 1);
  const MatrixXd gain = solve_observation(G, weights).gain;

  const double period = 1.0 / rig.excitation.frequency_hz;
  const TestFunction chi;
  std::vector<MatrixXd> normal(static_cast<std::size_t>(elements), MatrixXd::Zero(2, 2));
  std::vector<VectorXd> right(static_cast<std::size_t>(elements), VectorXd::Zero(2));
  for (const double asked : {0.5 * period, period}) {
    const double half = std::min(asked, (to - from) / 4);
    if (!(half > 0)) return out;
    for (double middle = from + half; middle + half <= to; middle += 0.25 * half) {
      const MatrixXd x = window(all, gain, chi, middle, half);
      Eigen::RowVector3d force = Eigen::RowVector3d::Zero(), y = x.topRows(n + 1).colwise().sum();
      if (rig.boundary == Boundary::clamped) force = x.row(n + 1);
      double left = force(0);  // of masses k … n
      for (int k = elements; k >= 1; --k) {
        Eigen::RowVector2d row;
        if (k == n + 1) {
          row << y(0), -y(1);
        } else {
          left += rig.masses[static_cast<std::size_t>(k - 1)] * x.topRows(k + 1).col(2).sum();
          row << -x(k, 0), x(k, 1);
        }
        const double value = k == n + 1 ? force(0) : left;
        normal[static_cast<std::size_t>(k - 1)] += row.transpose() * row;
        right[static_cast<std::size_t>(k - 1)] += row.transpose() * value;
      }
    }
  }
  for (int e = 0; e < elements; ++e) {
    const auto i = static_cast<std::size_t>(e);
    const VectorXd solution = normal[i].colPivHouseholderQr().solve(right[i]);
    out.stiffness(e) = solution(0);
    out.damping(e) = solution(1);
  }
  return out;
}

}  // namespace dwell
