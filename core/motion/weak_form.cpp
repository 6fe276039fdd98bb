#include "core/motion/weak_form.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/base/median.hpp"
#include "core/rig/observation.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPower = 6;   // of 1 - u²: derivatives up to the fifth vanish at the ends
constexpr int kOrders = 5;  // χ … χ''''
// Radians of the drive from reading to reading up to which a cubic through four evenly spaced ones follows it, to a
// twentieth of its amplitude. Doubled: to half of it.
constexpr double kFollows = 1.2;
// The same for a channel that is read more slowly, in its median intervals: beyond, three readings in a row were lost.
// Halved: the jitter of polling makes gaps. Doubled: a cubic goes across five lost readings.
constexpr double kPause = 3.0;
// Twice the unknowns of an element. Halved: noise alone decides. Doubled: a short first stretch has no start.
constexpr int kFewestWindows = 4;

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
  // Whether two readings next to each other are further apart than that, somewhere in [from, to].
  [[nodiscard]] bool has_gap(double from, double to, double longest_s) const {
    auto i = static_cast<std::size_t>(std::upper_bound(t_s.begin(), t_s.end(), from) - t_s.begin());
    for (i = std::max<std::size_t>(i, 1); i < t_s.size() && t_s[i - 1] < to; ++i)
      if (t_s[i] - t_s[i - 1] > longest_s) return true;
    return false;
  }
  // At least two readings.
  [[nodiscard]] double median_interval() const {
    std::vector<double> intervals;
    for (std::size_t i = 1; i < t_s.size(); ++i) intervals.push_back(t_s[i] - t_s[i - 1]);
    return median(std::move(intervals));
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

// Normal equations of one element.
struct Normal {
  MatrixXd matrix = MatrixXd::Zero(2, 2);
  VectorXd right = VectorXd::Zero(2);
  double squares = 0.0;  // of the left sides
  void add(const Eigen::RowVector2d& row, double left) {
    matrix += row.transpose() * row;
    right += row.transpose() * left;
    squares += left * left;
  }
};

// The windows over [from, to], where every channel has readings.
class Windows {
 public:
  Windows(const Rig& rig, const std::vector<Series>& all, const MatrixXd& gain, double from, double to)
      : rig_(rig), all_(all), gain_(gain), from_(from), to_(to) {
    const double follows_s = kFollows / (kTwoPi * rig.excitation.frequency_hz);
    for (Index c = 0; c < gain.cols(); ++c)
      longest_s_.push_back(counts(c) ? std::max(follows_s, kPause * series(c).median_interval()) : 0.0);
  }

  // Adds up the normal equations of all elements; returns over how many windows. Windows in which some channel has a
  // gap are left out: a cubic across a gap of some periods is no motion.
  int sum(std::vector<Normal>& of) const {
    int windows = 0;
    const double period = 1.0 / rig_.excitation.frequency_hz;
    for (const double asked : {0.5 * period, period}) {
      const double half = std::min(asked, (to_ - from_) / 4);
      if (!(half > 0)) break;
      for (double middle = from_ + half; middle + half <= to_; middle += 0.25 * half) {
        if (has_gap(middle - half, middle + half)) continue;
        add(middle, half, of);
        ++windows;
      }
    }
    return windows;
  }

 private:
  [[nodiscard]] bool counts(Index c) const { return !gain_.col(c).isZero(0.0); }
  [[nodiscard]] const Series& series(Index c) const { return all_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] bool has_gap(double from, double to) const {
    for (Index c = 0; c < gain_.cols(); ++c)
      if (counts(c) && series(c).has_gap(from, to, longest_s_[static_cast<std::size_t>(c)])) return true;
    return false;
  }
  // (Y_0, d_1 … d_n, F) under χ'', χ''' and χ''''.
  [[nodiscard]] MatrixXd window(double middle, double half) const {
    MatrixXd observed = MatrixXd::Zero(gain_.cols(), 3);
    for (Index c = 0; c < gain_.cols(); ++c)
      if (counts(c)) observed.row(c) = series(c).integrals(chi_, middle, half).transpose();
    return gain_ * observed;
  }
  // The window's row in the equations of each element.
  void add(double middle, double half, std::vector<Normal>& to) const {
    const int n = rig_.mass_count();
    const MatrixXd x = window(middle, half);
    Eigen::RowVector3d force = Eigen::RowVector3d::Zero(), y = x.topRows(n + 1).colwise().sum();
    if (rig_.boundary == Boundary::clamped) force = x.row(n + 1);
    double left = force(0);  // of masses k … n
    for (int k = rig_.element_count(); k >= 1; --k) {
      Eigen::RowVector2d row;
      if (k == n + 1) {
        row << y(0), -y(1);
      } else {
        left += rig_.masses[static_cast<std::size_t>(k - 1)] * x.topRows(k + 1).col(2).sum();
        row << -x(k, 0), x(k, 1);
      }
      to[static_cast<std::size_t>(k - 1)].add(row, k == n + 1 ? force(0) : left);
    }
  }

  const Rig& rig_;
  const std::vector<Series>& all_;
  const MatrixXd& gain_;
  double from_, to_;
  std::vector<double> longest_s_;  // between readings, per channel: a gap beyond
  TestFunction chi_;
};

}  // namespace

WeakForm weak_form(const Rig& rig, const MotionData& data) {
  const int n = rig.mass_count(), elements = rig.element_count();
  WeakForm out;
  out.stiffness = out.damping = out.coherence = VectorXd::Constant(elements, std::numeric_limits<double>::quiet_NaN());
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

  std::vector<Normal> normal(static_cast<std::size_t>(elements));
  if (Windows(rig, all, gain, from, to).sum(normal) < kFewestWindows) return out;
  for (std::size_t e = 0; e < normal.size(); ++e) {
    const VectorXd solution = normal[e].matrix.colPivHouseholderQr().solve(normal[e].right);
    out.stiffness(static_cast<Index>(e)) = solution(0);
    out.damping(static_cast<Index>(e)) = solution(1);
    out.coherence(static_cast<Index>(e)) = solution.dot(normal[e].right) / normal[e].squares;
  }
  return out;
}

}  // namespace dwell
