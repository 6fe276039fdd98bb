#include "core/motion/unchecked.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/wording.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

// A direction with less information than this, in natural sizes, is not determined: its u is above a tenth. Common
// delays come to 20, since the process that stands for the table is not quite the same at every instant.
constexpr double kNotTold = 100.0;
// Terms may cancel. A remainder below this part of a term's own information is rounding. A direction with less
// information than that counts as not determined.
constexpr double kCancelled = 1e-10;
// Components of a direction below this are ignored.
constexpr double kNoPart = 0.05;

// The reduced row echelon form of a basis of the null space: each direction involves few terms.
MatrixXd reduced(MatrixXd rows) {
  Index done = 0;
  for (Index column = 0; column < rows.cols() && done < rows.rows(); ++column) {
    Index best = done;
    rows.col(column).tail(rows.rows() - done).cwiseAbs().maxCoeff(&best);
    best += done;
    if (std::abs(rows(best, column)) < kNoPart) continue;
    rows.row(done).swap(rows.row(best));
    rows.row(done) /= rows(done, column);
    for (Index other = 0; other < rows.rows(); ++other)
      if (other != done) rows.row(other) -= (rows(other, column) * rows.row(done)).eval();
    ++done;
  }
  return rows.topRows(done);
}

// Terms of one kind, moving alike: "the common delay of y0 and y1". Others by their names.
std::string told(const Rig& rig, const std::vector<Parameter>& terms, bool alike) {
  std::vector<std::string> names;
  const bool one_kind =
      std::all_of(terms.begin(), terms.end(), [&](const Parameter& p) { return p.what == terms.front().what; });
  if (terms.size() == 1 || !one_kind || !alike) {
    for (const Parameter& p : terms) names.push_back(name_of(rig, p));
    return terms.size() == 1 ? names.front() : "an error that " + listed(names) + " share";
  }
  for (const Parameter& p : terms)
    names.push_back(p.what == Unknown::mass ? name_of(rig, p) : rig.channels[static_cast<std::size_t>(p.index)].name);
  return std::string("the common ") + (terms.front().what == Unknown::delay ? "delay of " : "scale of ") +
         listed(names);
}

}  // namespace

std::vector<std::string> unchecked(const Rig& rig, const ScoreTest& test) {
  std::vector<Index> terms;
  for (Index a = 0; a < test.sizes.size(); ++a) {
    const Unknown what = test.candidates[static_cast<std::size_t>(a)].what;
    if (what == Unknown::mass || what == Unknown::scale || what == Unknown::delay) terms.push_back(a);
  }
  if (terms.empty()) return {};
  std::stable_sort(terms.begin(), terms.end(), [&](Index a, Index b) {
    return test.candidates[static_cast<std::size_t>(a)].what < test.candidates[static_cast<std::size_t>(b)].what;
  });
  // In natural sizes, or in smaller ones where rounding would tell of those.
  const Eigen::VectorXd natural = test.sizes(terms);
  const Eigen::VectorXd size =
      natural.cwiseMin((0.5 * kNotTold / kCancelled * test.own(terms).cwiseInverse()).cwiseSqrt());
  const MatrixXd W = size.asDiagonal() * test.alone(terms, terms) * size.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(W);
  const Index null = (solver.eigenvalues().array() < kNotTold).count();
  const auto all = static_cast<Index>(terms.size());
  // Any motion leaves the common mass, scale and delay of a chain unknown: three combinations. A steady motion leaves
  // most others unknown too; then their number says more than a list of a dozen.
  if (null > 3 && 2 * null > all)
    return {"most errors of masses, scales and delays: this motion tells only " + std::to_string(all - null) + " of " +
            std::to_string(all) + " combinations of them"};
  std::vector<std::string> out;
  MatrixXd basis = solver.eigenvectors().leftCols(null).transpose() * size.cwiseQuotient(natural).asDiagonal();
  basis.rowwise().normalize();
  const MatrixXd directions = reduced(basis);
  for (Index i = 0; i < directions.rows(); ++i) {
    std::vector<Parameter> in;
    bool alike = true;
    for (Index a = 0; a < directions.cols(); ++a) {
      if (std::abs(directions(i, a)) < kNoPart) continue;
      in.push_back(test.candidates[static_cast<std::size_t>(terms[static_cast<std::size_t>(a)])]);
      alike = alike && std::abs(directions(i, a) - 1) < kNoPart;
    }
    out.push_back(told(rig, in, alike));
  }
  return out;
}

}  // namespace dwell
