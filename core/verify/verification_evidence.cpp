#include "core/verify/verification_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/base/angle.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Draws of noise: u of the prediction is then known to 9 %, and so is the spread of a test's statistic.
constexpr Index kDraws = 64;
constexpr std::uint64_t kEvidenceSeed = 20161;

// Places rows of one stretch into those of all; an empty matrix stays empty.
void place(const MatrixXd& from, Index at, Index count, double scale, Index to, Index total, MatrixXd& out) {
  if (out.size() == 0) out.resize(total, from.cols());
  if (from.cols() == 0) return;  // no memory, in which a row could have a place
  out.middleRows(to, count) = scale * from.middleRows(at, count);
}
void place(const VectorXd& from, Index at, Index count, double scale, Index to, Index total, VectorXd& out) {
  if (out.size() == 0) out.resize(total);
  out.segment(to, count) = scale * from.segment(at, count);
}

}  // namespace

Index VerificationEvidence::Part::count(int channel) const {
  if (std::find(stretch.compared.begin(), stretch.compared.end(), channel) == stretch.compared.end()) return 0;
  return static_cast<Index>(stretch.readings[static_cast<std::size_t>(channel)].t_ns.size() -
                            stretch.unscored(channel));
}

void VerificationEvidence::add(VerificationStretch stretch, const Dwell& of, const Rig& rig) {
  const auto t = static_cast<std::size_t>(stretch.table);
  const double amplitude =
      std::abs(of.phasors[t].Y) / std::pow(stretch.omega, derivative_order(rig.channels[t].measures));
  if (parts_.empty()) amplitude_ = amplitude;
  std::vector<double> freedom;
  for (std::size_t c = 0; c < of.phasors.size(); ++c) {
    // Of the mean square of noise, the relative variance: as known in the steady motion, and by what m leaves open.
    const TimingNoise& timing = stretch.timing[c];
    const double open = timing.u * (timing.mean_square_velocity(stretch.readings[c]) - 1);
    freedom.push_back(2 / (2 / std::max(1.0, of.phasors[c].samples) + open * open));
  }
  SteadyTable table(stretch.readings[t], stretch.sigma[t], stretch.omega, rig.excitation.harmonics);
  // Far from the seed of anything else that is drawn.
  NoiseDraws draws(stretch, kDraws, kEvidenceSeed + 1000 * parts_.size());
  parts_.push_back(
      {std::move(stretch), std::move(table), std::move(draws), amplitude_ / amplitude, std::move(freedom)});
}

std::vector<int> VerificationEvidence::compared() const {
  std::set<int> out;
  for (const Part& part : parts_) out.insert(part.stretch.compared.begin(), part.stretch.compared.end());
  return {out.begin(), out.end()};
}

std::vector<VerificationEvidence::Rows> VerificationEvidence::channels() const {
  std::vector<Rows> out;
  Index begin = 0;
  for (const int c : compared()) {
    Rows rows{c, begin, 0, 0.0, 1e300};
    for (const Part& part : parts_) {
      const Index count = part.count(c);
      if (count == 0) continue;
      const auto i = static_cast<std::size_t>(c);
      const double sigma = part.scale * part.stretch.sigma[i];
      rows.sigma += static_cast<double>(count) * sigma * sigma;
      rows.count += count;
      rows.freedom = std::min(rows.freedom, part.freedom[i]);
    }
    rows.sigma = std::sqrt(rows.sigma / static_cast<double>(rows.count));
    begin += rows.count;
    out.push_back(rows);
  }
  return out;
}

std::vector<Index> VerificationEvidence::ends() const {
  std::vector<Index> out;
  Index end = 0;
  for (const int c : compared())
    for (const Part& part : parts_)
      if (const Index count = part.count(c); count > 0) out.push_back(end += count);
  return out;
}

Residuals VerificationEvidence::residuals(const Assumption& assumption, Knots knots, bool with_noise,
                                          const SteadyRatio* steady) const {
  std::vector<Residuals> of_part;
  for (const Part& part : parts_) {
    of_part.push_back(
        residuals_of(part.stretch, part.table, assumption, knots, with_noise ? &part.draws : nullptr, steady));
    if (!of_part.back().fault.empty()) return std::move(of_part.back());
  }
  if (of_part.size() == 1) return std::move(of_part.front());
  const Index total = ends().back();
  std::vector<Index> at(parts_.size(), 0);
  Residuals out;
  Index to = 0;
  for (const int c : compared())
    for (std::size_t p = 0; p < parts_.size(); ++p) {
      const Index count = parts_[p].count(c);
      const double scale = parts_[p].scale;
      const Residuals& from = of_part[p];
      place(from.predicted, at[p], count, scale, to, total, out.predicted);
      place(from.measured, at[p], count, scale, to, total, out.measured);
      place(from.beyond_steady, at[p], count, scale, to, total, out.beyond_steady);
      place(from.noise_predicted, at[p], count, scale, to, total, out.noise_predicted);
      place(from.noise_error, at[p], count, scale, to, total, out.noise_error);
      place(from.noise_beyond_steady, at[p], count, scale, to, total, out.noise_beyond_steady);
      at[p] += count;
      to += count;
    }
  return out;
}

}  // namespace dwell
