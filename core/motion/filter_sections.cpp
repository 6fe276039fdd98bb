#include "core/motion/filter_sections.hpp"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/complex.hpp"

namespace dwell {
namespace {

// Poles with Im >= 0 of a Butterworth low-pass of corner 1 rad/s.
std::vector<Complex> butterworth_poles(int order) {
  std::vector<Complex> poles;
  for (int k = 0; 2 * k < order; ++k)
    poles.push_back(std::polar(1.0, std::numbers::pi / 2 + std::numbers::pi * (2 * k + 1) / (2.0 * order)));
  return poles;
}

// The corner, where the magnitude of Π |p|/|jw - p| over all poles has fallen to 1/√2, by bisection: it falls steadily.
double corner_of(const Eigen::VectorXcd& poles) {
  double low = 0.0, high = 10.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    double power = 1.0;
    for (const Complex& p : poles) power *= std::norm(p) / std::norm(Complex{0.0, middle} - p);
    (power > 0.5 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// The same of a Bessel low-pass: roots of the reverse Bessel polynomial Σ a_k s^k, a_k = (2n-k)! / (2^(n-k) k! (n-k)!).
std::vector<Complex> bessel_poles(int order) {
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(order, order);
  double a = 1.0;  // a_n, then downwards
  for (int k = order; k > 0; --k) {
    a *= 0.5 * (2 * order - k + 1) * k / (order - k + 1);  // a_{k-1}
    companion(0, order - k) = -a;
  }
  companion.diagonal(-1).setOnes();
  const Eigen::VectorXcd poles = Eigen::EigenSolver<Eigen::MatrixXd>(companion, false).eigenvalues();
  const double corner = corner_of(poles);
  std::vector<Complex> upper;
  for (const Complex& p : poles)
    if (p.imag() > -1e-9 * std::abs(p)) upper.push_back(p / corner);
  return upper;
}

}  // namespace

std::vector<FilterSection> filter_sections(const Filter& filter, bool high) {
  const double corner = kTwoPi * filter.hz;
  if (filter.kind == FilterKind::none) return {};
  if (filter.kind == FilterKind::rc)
    return std::vector<FilterSection>(static_cast<std::size_t>(filter.order), {1, corner, 0.0});
  std::vector<FilterSection> out;
  for (Complex p : filter.kind == FilterKind::bessel ? bessel_poles(filter.order) : butterworth_poles(filter.order)) {
    if (high) p = 1.0 / p;
    const bool real = std::abs(p.imag()) < 1e-9 * std::abs(p);
    out.push_back({real ? 1 : 2, corner * std::abs(p), real ? 0.0 : -p.real() / std::abs(p)});
  }
  return out;
}

int state_count(const Filter& filter) { return filter.kind == FilterKind::none ? 0 : filter.order; }

Eigen::RowVectorXd add_filter(const Filter& filter, bool high, Eigen::RowVectorXd input, Eigen::Index first,
                              Eigen::MatrixXd& A, bool couple_only) {
  for (const FilterSection& section : filter_sections(filter, high)) {
    const Eigen::Index last = first + section.order - 1;  // the state that the input drives
    A.row(last) += section.w * input;
    if (!couple_only) {
      A(last, first) -= section.w;
      if (section.order == 2) {
        A(first, last) += section.w;
        A(last, last) -= 2 * section.damping * section.w;
      }
    }
    if (!high) input.setZero();
    if (!couple_only) {
      input(first) += high ? -1.0 : 1.0;
      if (high && section.order == 2) input(last) -= 2 * section.damping;
    }
    first += section.order;
  }
  return input;
}

std::vector<double> filter_polynomial(const Filter& filter) {
  std::vector<double> product{1.0};
  for (const FilterSection& section : filter_sections(filter, false)) {
    // 1 + 2 ζ x + x² or 1 + x, with x = s/w.
    const double w = section.w / (kTwoPi * filter.hz);
    std::vector<double> factor{1.0, (section.order == 2 ? 2 * section.damping : 1.0) / w};
    if (section.order == 2) factor.push_back(1.0 / (w * w));
    std::vector<double> next(product.size() + factor.size() - 1, 0.0);
    for (std::size_t i = 0; i < product.size(); ++i)
      for (std::size_t j = 0; j < factor.size(); ++j) next[i + j] += product[i] * factor[j];
    product = std::move(next);
  }
  return product;
}

}  // namespace dwell
