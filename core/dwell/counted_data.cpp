#include "core/dwell/counted_data.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/instants.hpp"
#include "core/drive/refine.hpp"
#include "core/fit/scatter.hpp"

namespace dwell {
namespace {

constexpr int kTurns = 5;                     // sums of the data, at most, each at a better ω
constexpr std::int64_t kEnoughQuarters = 40;  // from then on an eighth of the data may be dropped
constexpr double kMisjudged = 3e-4;           // relative error of ω in a block whose turning costs 1e-8
constexpr double kShortestDrift = 20.0;       // periods
constexpr double kDriftMatters = 0.02;        // rad per square of the data's length
constexpr double kGrowth = 1.17;              // of the data, before ω is refined again

constexpr double kAcquired = 1e-2;  // largest relative standard uncertainty of ω

// The instant about which sums of these data are turned to another ω at the least cost.
std::int64_t middle_ns(std::int64_t begin_ns, std::int64_t end_ns) { return begin_ns + (end_ns - begin_ns) / 2; }

}  // namespace

CountedData::CountedData(const Rig& rig, const LiveChannels& channels, const DriveReference& reference)
    : rig_(rig),
      channels_(channels),
      reference_(reference),
      blocks_(channels.count(), rig.excitation.harmonics),
      window_(channels.count(), rig.excitation.harmonics),
      counted_(channels.count(), rig.excitation.harmonics),
      gathered_(channels.count(), rig.excitation.harmonics),
      totals_(channels.count(), rig.excitation.harmonics),
      omega_(nominal_omega()) {}

void CountedData::take_drive(double omega, const Blocks::Drift& drift) noexcept {
  omega_ = omega;
  blocks_.set_drift(drift);
}

void CountedData::acquire(int from, int to, std::int64_t centre_ns, double near) noexcept {
  double w = near, information = 0.0;
  for (int step = 0; step < kMostSteps; ++step) {
    const HarmonicFit table = fit(channels_.drive(), from, to, w, centre_ns);
    if (!(table.information > 0)) return;
    information = table.information;
    w = within_search(rig_, w + table.score / table.information);
  }
  if (1 / std::sqrt(information) < kAcquired * w) omega_ = w;
}

double CountedData::omega_at(std::int64_t t_ns, double omega) const noexcept {
  return omega + drift().rate * to_s(t_ns - drift().about_ns);
}

double CountedData::bend(std::int64_t t_ns) const noexcept {
  const double since_s = to_s(t_ns - drift().about_ns);
  return 0.5 * drift().rate * since_s * since_s;
}

void CountedData::open(std::int64_t begin_ns) noexcept {
  blocks_.open(begin_ns, begin_ns + to_ns(period_s() / kQuarters), omega_);
}

void CountedData::take_block(std::int64_t end_ns) noexcept {
  if (blocks_.forget_before(end_ns - to_ns(rig_.memory_s))) sums_valid_ = false;
  if (sums_valid_) blocks_.add_block(blocks_.count() - 1, counted_);
}

void CountedData::begin_hold(int from) noexcept {
  blocks_.forget_before(blocks_.block(from).begin_ns);
  blocks_.set_drift({});
  sums_valid_ = false;
  if (reference_.inexact() && !std::isfinite(omega_)) forget_omega();
}

void CountedData::stop_counting(std::int64_t t_ns) noexcept {
  sums_valid_ = false;
  take_drive(omega_at(t_ns, omega_), {});
}

HarmonicFit CountedData::fit(int channel, int from, int to, double omega, std::int64_t t_ns,
                             int harmonics) const noexcept {
  blocks_.sum_channel(channel, from, to, omega, t_ns, window_);
  return fit_harmonics(window_, channel, harmonics, blocks_.reference(channel));
}

HarmonicFit CountedData::fit(int channel, int from, int to, double omega, std::int64_t t_ns) const noexcept {
  return fit(channel, from, to, omega, t_ns, H());
}

void CountedData::fit_all(int from, int to, std::int64_t t_ns, std::vector<HarmonicFit>& fits) const noexcept {
  blocks_.sum(from, to, omega_, t_ns, window_);
  HarmonicFits of_window(window_, H());
  for (int c = 0; c < channels_.count(); ++c)
    fits[static_cast<std::size_t>(c)] = of_window.fit(c, blocks_.reference(c));
}

HarmonicFit CountedData::fit_now(int channel, int from, bool counting, std::int64_t t_ns) const noexcept {
  if (counting && sums_valid_)
    counted_.turned(omega_, t_ns, window_);
  else
    blocks_.sum(from, blocks_.count(), omega_, t_ns, window_);
  blocks_.add_open(window_);
  return fit_harmonics(window_, channel, H(), blocks_.reference(channel));
}

HarmonicFit CountedData::fit_counted(int channel) const noexcept {
  return fit_harmonics(counted_, channel, H(), blocks_.reference(channel));
}

std::optional<CountedData::Table> CountedData::resum(std::int64_t hold_ns) noexcept { return resum(hold_ns, true); }

std::optional<CountedData::Table> CountedData::resum(std::int64_t hold_ns, bool follow) noexcept {
  sums_valid_ = false;
  if (blocks_.count() == 0) return {};
  double u_omega = 0.0;
  for (int i = 0; i < kTurns; ++i) {
    const std::int64_t begin_ns = blocks_.block(0).begin_ns, end_ns = blocks_.block(blocks_.count() - 1).end_ns;
    blocks_.sum(0, blocks_.count(), omega_, middle_ns(begin_ns, end_ns), counted_);
    const Refined refined = reference_.refine(counted_, begin_ns, end_ns, hold_ns, channels_.drive(), totals_);
    omega_ = refined.omega;
    u_omega = refined.u;
    if (refined.sums_valid) break;
  }
  if (drop_misjudged()) return resum(hold_ns, follow);
  if (follow && follow_drift()) return resum(hold_ns, false);
  // The last sum is about the centroid, where turning costs least.
  const std::int64_t centroid_ns = counted_.centroid_ns(channels_.drive());
  refer_drift(centroid_ns);
  blocks_.sum(0, blocks_.count(), omega_, centroid_ns, counted_);
  sums_valid_ = true;
  const std::int64_t first = blocks_.block(0).first_serial;
  refine_at_serial_ = first + static_cast<std::int64_t>(kGrowth * static_cast<double>(blocks_.serials() - first)) + 1;
  return Table{fit_counted(channels_.drive()), centroid_ns, u_omega};
}

bool CountedData::follow_drift() noexcept {
  const std::int64_t about_ns = counted_.centroid_ns(channels_.drive());
  const double more = seen_drift(0, omega_, about_ns);
  if (more == 0) return false;
  refer_drift(about_ns);
  blocks_.set_drift({drift().rate + more, about_ns});
  return true;
}

double CountedData::seen_drift(int first, double omega, std::int64_t about_ns) const noexcept {
  if (!reference_.from_motion() || blocks_.count() - first < kStretches) return 0.0;
  const std::int64_t length_ns = blocks_.block(blocks_.count() - 1).end_ns - blocks_.block(first).begin_ns;
  if (to_s(length_ns) < kShortestDrift * period_s()) return 0.0;
  // Fits a parabola to the table's phase, relative to the dwell's, in stretches of equal length. One noise is taken for
  // all stretches: that of a stretch of few readings is itself uncertain.
  struct DrivePhase {
    double u, phase, information;  // information: for noise of unit variance
  };
  std::array<DrivePhase, 2 * kStretches> stretches;
  std::size_t count = 0;
  double before = 0.0, squares = 0.0, freedom = 0.0;
  for (int from = first, to = first; from < blocks_.count() && count < stretches.size(); from = to) {
    const std::int64_t first_ns = blocks_.block(from).begin_ns;
    while (to < blocks_.count() && (to == from || blocks_.block(to).begin_ns - first_ns < length_ns / kStretches)) ++to;
    const HarmonicFit fit = this->fit(channels_.drive(), from, to, omega, about_ns);
    if (!fit.usable || !(fit.sigma2 > 0)) continue;
    const double u = to_s((blocks_.block(to - 1).end_ns + first_ns) / 2 - about_ns) / to_s(length_ns);
    const double phase = before + std::remainder(std::arg(fit.X[0]) - before, kTwoPi);
    before = phase;
    stretches[count++] = {u, phase, std::norm(fit.X[0]) * fit.sigma2 / (0.5 * fit.covariance.trace())};
    squares += fit.sigma2 * (fit.samples - (2 * H() + 1));
    freedom += fit.samples - (2 * H() + 1);
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
  // A drift within its uncertainty, or one that hardly turns a phasor, is ignored.
  if (!(std::abs(more) > sigmas::kShown * u_more && std::abs(more) > kDriftMatters)) return 0.0;
  return more / (to_s(length_ns) * to_s(length_ns));
}

// Refers the same drift to another instant, where the frequency is another.
void CountedData::refer_drift(std::int64_t about_ns) noexcept {
  take_drive(omega_at(about_ns, omega_), {drift().rate, about_ns});
}

// Drops the first blocks of a hold if they were taken at a wrong frequency: turning them loses (δu)²/6 of the
// amplitude. They are dropped only if they are few and the loss matters beside the uncertainty.
bool CountedData::drop_misjudged() noexcept {
  const std::int64_t first = blocks_.block(0).first_serial, all = blocks_.serials() - first;
  if (all < kEnoughQuarters) return false;
  double loss = 0.0;
  std::int64_t good_from_ns = INT64_MIN;
  for (int i = 0; i < blocks_.count(); ++i) {
    const Blocks::Block& block = blocks_.block(i);
    const double turned = (block.omega / omega_ - 1) * std::numbers::pi / 4;
    loss += turned * turned / 6 * block.quarters / static_cast<double>(all);
    if (block.first_serial - first <= all / 8 && std::abs(block.omega / omega_ - 1) > kMisjudged)
      good_from_ns = block.end_ns;
  }
  const HarmonicFit fit = fit_harmonics(totals_, channels_.drive(), H(), 0.0);
  if (good_from_ns == INT64_MIN || !(loss * std::abs(fit.X[0]) > 0.1 * std::sqrt(0.5 * fit.covariance.trace())))
    return false;
  return blocks_.forget_before(good_from_ns);
}

Refined CountedData::gather(int from, int to, bool with_open, std::int64_t now_ns,
                            std::int64_t hold_ns) const noexcept {
  const std::int64_t begin_ns = from < to ? blocks_.block(from).begin_ns : now_ns;
  const std::int64_t end_ns = with_open || from == to ? now_ns : blocks_.block(to - 1).end_ns;
  Refined refined{.omega = omega_, .sums_valid = false};
  for (int i = 0; i < kTurns && !refined.sums_valid; ++i) {
    if (i == 0 && from == 0 && to == blocks_.count() && sums_valid_)
      counted_.turned(counted_.omega(), counted_.t_ref_ns(), gathered_);
    else
      blocks_.sum(from, to, refined.omega, middle_ns(begin_ns, end_ns), gathered_);
    if (with_open) blocks_.add_open(gathered_);
    refined = reference_.refine(gathered_, begin_ns, end_ns, hold_ns, channels_.drive(), totals_);
  }
  return refined;
}

std::vector<std::vector<PhasorStretch>> CountedData::stretches(int from, int to,
                                                               std::span<const HarmonicFit* const> fits) const {
  return phasor_stretches(blocks_, from, to, H(), fits, totals_.omega(), totals_.t_ref_ns(), window_);
}

}  // namespace dwell
