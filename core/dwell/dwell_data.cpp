#include <Eigen/Cholesky>
#include <array>

#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr int kTurns = 3;                     // times that data are summed anew at a better ω
constexpr std::int64_t kEnoughQuarters = 40;  // of which an eighth may go
constexpr double kMisjudged = 3e-4;           // relative error of ω in a block whose turning costs 1e-8
constexpr double kBeats = 0.5;                // of the drive's frequency: what is farther from it averages out
constexpr int kStretches = 12;                // in which the drive's phase is looked at
constexpr double kShortestDrift = 20.0;       // periods
constexpr double kSureOfDrift = 4.0;          // standard deviations
constexpr double kDriftMatters = 0.02;        // rad per square of the data's length
constexpr double kGrowth = 1.17;              // of the data, before ω is refined again

}  // namespace

void Pipeline::Impl::count_anew(bool follow) {
  counted_valid = false;
  if (blocks.count() == 0) return;
  double u_omega = 0.0;
  for (int i = 0; i < kTurns; ++i) {
    blocks.sum(0, blocks.count(), omega, blocks.block(0).begin_ns, counted);
    const Refined refined = reference.refine(counted, blocks.block(0).begin_ns, blocks.block(blocks.count() - 1).end_ns,
                                             at.steady_ns, drive_channel(), totals);
    omega = refined.omega;
    u_omega = refined.u;
    if (refined.reached) break;
  }
  if (drop_misjudged()) return count_anew(follow);
  if (follow && follow_drift()) return count_anew(false);
  // Once more about the centroid, where turning costs least.
  const std::int64_t centroid_ns = counted.centroid_ns(drive_channel());
  refer_drift(centroid_ns);
  blocks.sum(0, blocks.count(), omega, centroid_ns, counted);
  counted_valid = true;
  const HarmonicFit fit = fit_harmonics(counted, drive_channel(), H, blocks.reference(drive_channel()));
  const Complex X = fit.X[0];
  const double drift = blocks.drift().rate;
  hold = {centroid_ns, std::arg(X), omega, u_omega, fit.sigma2};
  drive.refer(std::abs(as_observed(rig, drive_channel(), X, omega, 1)), omega);
  const double u = std::sqrt(0.5 * fit.covariance.trace()) / std::abs(X);
  if (fit.usable) {
    // What the table alone tells of its frequency: the others' motion may hold a little of their transient.
    const bool told = tracked() && fit.information > 0;
    const double information = fit.information + reference.stated().information();
    const double table_omega = told ? omega + (fit.score + reference.stated().score(omega)) / information : omega;
    const double u_table_omega = told ? 1 / std::sqrt(information) : u_omega;
    watch.refer({centroid_ns, fit.mean, fit.X, H, table_omega, drift, std::sqrt(fit.sigma2), u, u, u_table_omega,
                 quantization_u(drive_channel(), fit, counted) / std::abs(X)});
    const SamplingRegularity& sampling = live[drive_channel()].sampling();
    watch.expect_beats(
        std::any_of(std::begin(kMainsFundamentals_hz), std::end(kMainsFundamentals_hz),
                    [&](double line) { return sampling.distance_hz(line, omega / kTwoPi) < kBeats * omega / kTwoPi; }));
  }
  const std::int64_t first = blocks.block(0).first_serial;
  refine_at_serial = first + static_cast<std::int64_t>(kGrowth * static_cast<double>(blocks.serials() - first)) + 1;
}

bool Pipeline::Impl::follow_drift() {
  const std::int64_t about_ns = counted.centroid_ns(drive_channel());
  const double more = seen_drift(0, omega, about_ns);
  if (more == 0) return false;
  refer_drift(about_ns);
  blocks.set_drift({blocks.drift().rate + more, about_ns});
  return true;
}

double Pipeline::Impl::seen_drift(int first, double w, std::int64_t about_ns) const {
  if (!from_motion() || blocks.count() - first < kStretches) return 0.0;
  const std::int64_t length_ns = blocks.block(blocks.count() - 1).end_ns - blocks.block(first).begin_ns;
  if (to_s(length_ns) < kShortestDrift * period_s()) return 0.0;
  // The table's phase in stretches of like length against the dwell's, a parabola through it. All have one noise: that
  // of few readings is itself uncertain.
  struct Stretch {
    double u, phase, information;  // of unit variance
  };
  std::array<Stretch, 2 * kStretches> stretches;
  std::size_t count = 0;
  double before = 0.0, squares = 0.0, freedom = 0.0;
  for (int from = first, to = first; from < blocks.count() && count < stretches.size(); from = to) {
    const std::int64_t first_ns = blocks.block(from).begin_ns;
    while (to < blocks.count() && (to == from || blocks.block(to).begin_ns - first_ns < length_ns / kStretches)) ++to;
    blocks.sum_channel(drive_channel(), from, to, w, about_ns, window);
    const HarmonicFit fit = fit_harmonics(window, drive_channel(), H, 0.0);
    if (!fit.usable || !(fit.sigma2 > 0)) continue;
    const double u = to_s((blocks.block(to - 1).end_ns + first_ns) / 2 - about_ns) / to_s(length_ns);
    const double phase = before + std::remainder(std::arg(fit.X[0]) - before, kTwoPi);
    before = phase;
    stretches[count++] = {u, phase, std::norm(fit.X[0]) * fit.sigma2 / (0.5 * fit.covariance.trace())};
    squares += fit.sigma2 * (fit.samples - (2 * H + 1));
    freedom += fit.samples - (2 * H + 1);
  }
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    const double weight = stretches[i].information * freedom / squares;
    const Eigen::Vector3d x{1.0, stretches[i].u, 0.5 * stretches[i].u * stretches[i].u};
    N += weight * x * x.transpose();
    b += weight * stretches[i].phase * x;
  }
  const Eigen::LLT<Eigen::Matrix3d> llt(N);
  if (llt.info() != Eigen::Success) return 0.0;
  const double more = llt.solve(b)(2), u_more = std::sqrt(llt.solve(Eigen::Vector3d::Unit(2))(2));  // rad per length²
  // What turns the ends by less than it is uncertain, or a phasor by nothing that matters, is left alone.
  if (!(std::abs(more) > kSureOfDrift * u_more && std::abs(more) > kDriftMatters)) return 0.0;
  return more / (to_s(length_ns) * to_s(length_ns));
}

// About another instant the same drift goes with another frequency.
void Pipeline::Impl::refer_drift(std::int64_t about_ns) {
  omega = omega_at(about_ns, omega);
  blocks.set_drift({blocks.drift().rate, about_ns});
}

bool Pipeline::Impl::drop_misjudged() {
  const std::int64_t first = blocks.block(0).first_serial, all = blocks.serials() - first;
  if (all < kEnoughQuarters) return false;
  double loss = 0.0;
  std::int64_t good_from_ns = INT64_MIN;
  for (int i = 0; i < blocks.count(); ++i) {
    const Blocks::Block& block = blocks.block(i);
    const double turned = (block.omega / omega - 1) * std::numbers::pi / 4;
    loss += turned * turned / 6 * block.quarters / static_cast<double>(all);
    if (block.first_serial - first <= all / 8 && std::abs(block.omega / omega - 1) > kMisjudged)
      good_from_ns = block.end_ns;
  }
  const HarmonicFit fit = fit_harmonics(totals, drive_channel(), H, 0.0);
  if (good_from_ns == INT64_MIN || !(loss * std::abs(fit.X[0]) > 0.1 * std::sqrt(0.5 * fit.covariance.trace())))
    return false;
  return blocks.forget_before(good_from_ns);
}

Refined Pipeline::Impl::gather(int from, int to, bool with_open) const {
  const std::int64_t begin_ns = from < to ? blocks.block(from).begin_ns : now_ns;
  Refined refined{.omega = omega, .reached = false};
  for (int i = 0; i < kTurns && !refined.reached; ++i) {
    if (i == 0 && from == 0 && to == blocks.count() && counted_valid)
      counted.turned(counted.omega(), counted.t_ref_ns(), gathered);
    else
      blocks.sum(from, to, refined.omega, begin_ns, gathered);
    if (with_open) blocks.add_open(gathered);
    refined = reference.refine(gathered, begin_ns, with_open || from == to ? now_ns : blocks.block(to - 1).end_ns,
                               at.steady_ns, drive_channel(), totals);
  }
  return refined;
}

}  // namespace dwell
