#include "core/motion/motion_estimate.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/angle.hpp"
#include "core/base/instants.hpp"
#include "core/base/student.hpp"
#include "core/base/wording.hpp"
#include "core/motion/given_table.hpp"
#include "core/motion/inflated_process.hpp"
#include "core/motion/leftover.hpp"
#include "core/motion/missing_terms.hpp"
#include "core/motion/missing_wording.hpp"
#include "core/motion/motion_course.hpp"
#include "core/motion/pattern_in_noise.hpp"
#include "core/motion/told_inverse.hpp"
#include "core/motion/whiteness.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Blocks of two periods at least: from eight a standard deviation is known to 1/√16, a quarter. Fewer: u is widened or
// not by chance.
constexpr int kFewestBlocks = 8;
constexpr const char* kLookedForLater = "; what explains it is looked for with the next estimate";

class Report {
 public:
  Report(const Rig& rig, const MotionCourse& course)
      : rig_(rig), course_(course), coefficients_(2 * rig.element_count()), free_(0) {
    for (const Parameter& p : course.parameters) free_ += p.prior_u > 0 ? 0 : 1;
  }

  // Everything but the elements; with the reason where there are none.
  MotionEstimate judge() {
    MotionEstimate out;
    out.start_s = to_s(course_.data.readings.front().t_ns);
    out.end_s = to_s(course_.data.readings.back().t_ns);
    out.passes = course_.passes;
    out.reason = course_.reason;
    const auto fitted = static_cast<std::size_t>(course_.fit.at.theta.size());
    if (!std::isfinite(course_.fit.V) || fitted == 0 || fitted != course_.parameters.size()) return out;
    const MotionModel model = course_.model(rig_);
    pass_ = evaluate(model, course_.data, course_.fit.at, {.derivatives = false, .keep_innovations = true});
    given_table_ = innovations_given_table(model, course_.data, course_.fit.at);
    add_channels(out);
    if (out.reason.empty()) refuse_contradicted(out);
    return out;
  }

  // Gives the elements; `out` as judge() left it, without a reason. missing: terms that the readings ask for. The
  // coefficients stay as they are, and their uncertainty covers what such a term would make of them.
  void give_elements(const std::vector<MissingTerm>& missing, MotionEstimate& out) {
    spread_by_noise();
    widen(out);
    widen_by(missing);
    add_elements(out);
  }

 private:
  [[nodiscard]] double theta(Index a) const { return course_.fit.at.theta(a); }

  void add_channels(MotionEstimate& out) {
    for (std::size_t a = 0; a < course_.parameters.size(); ++a) {
      const Parameter& p = course_.parameters[a];
      if (p.what != Unknown::noise) continue;
      const auto c = static_cast<std::size_t>(p.index);
      MotionChannel channel;
      channel.channel = p.index;
      channel.u_noise = std::exp(theta(static_cast<Index>(a)));
      channel.chi2 = pass_.chi2[c];
      const Whiteness whiteness = whiteness_of(given_table_[c].empty() ? pass_.innovations[c] : given_table_[c]);
      channel.whiteness_p = whiteness.p;
      if (!shows_drive(rig_.channels[c]) && whiteness.p < kContradicted) strange_ += whiteness.squares;
      if (shows_drive(rig_.channels[c])) look_for_pattern(c, channel.u_noise, whiteness, out);
      const double beyond = channel.u_noise * channel.u_noise - course_.noise[c] * course_.noise[c];
      channel.unexplained = std::sqrt(std::max(0.0, beyond)) / std::max(course_.size[c], 1e-300);
      out.readings += static_cast<std::size_t>(pass_.count[c]);
      // The fitted noise means nothing if the search has not converged. The first such channel is named.
      if (channel.unexplained > kNotLinear && channel.u_noise > kMoreThanNoise * course_.noise[c] &&
          course_.fit.converged && !out.contradicted) {
        out.contradicted = true;
        out.reason = "no linear chain explains " + rig_.channels[c].name + ": " + percent(channel.unexplained) +
                     " of its motion is left over (noise from reading to reading: " +
                     percent(course_.noise[c] / course_.size[c]) + ")";
      }
      out.channels.push_back(channel);
    }
  }

  void look_for_pattern(std::size_t c, double u_noise, const Whiteness& whiteness, MotionEstimate& out) {
    const double pattern = pattern_in_noise(pass_, c, u_noise, whiteness);
    if (!(pattern > 0.0) || pattern <= error_of_rounding(course_.data, static_cast<int>(c))) return;
    pattern_ += whiteness.squares;
    out.patterns.push_back({rig_.channels[c].name, pattern / course_.size[c]});
    out.warnings.push_back(words_of_pattern(out.patterns.back()) +
                           ". These ± are wider for it. Those of the dwell are not");
  }

  // Covariance of the coefficients with what is stated taken as exact, and what each stated one adds.
  void spread_by_noise() {
    const MatrixXd& I = course_.fit.pass.information;
    const Index p = course_.fit.at.theta.size(), size = I.rows(), stated = p - free_;
    std::vector<Index> order;  // all but the stated ones, coefficients first
    for (Index i = 0; i < size; ++i)
      if (i < free_ || i >= p) order.push_back(i);
    const MatrixXd own = I(order, order), cross = I(order, Eigen::seqN(free_, stated));
    const MatrixXd all = ToldInverse(own, std::vector<bool>(order.size(), true)).matrix();
    noise_ = all.topLeftCorner(coefficients_, coefficients_);
    if (stated > 0) {
      by_stated_ = -(all * cross).topRows(coefficients_);
      of_stated_ = by_stated_ * course_.fit.covariance.block(free_, free_, stated, stated);
    }
    covariance_ = course_.fit.covariance.topLeftCorner(coefficients_, coefficients_);
    // The largest likelihood takes the noise for smaller than it is, by the part of the readings that the unknowns
    // take up.
    const double readings = reading_count(), left = std::max(1.0, readings - static_cast<double>(order.size()));
    noise_grows(readings / left);
  }
  [[nodiscard]] double reading_count() const { return std::accumulate(pass_.count.begin(), pass_.count.end(), 0.0); }

  // Channels behind the table whose whiteness has a p-value below by_chance. Only those where what is left is more than
  // `least`, a part of the channel's size.
  [[nodiscard]] std::vector<std::string> not_white(const MotionEstimate& out, double by_chance, double least) const {
    std::vector<std::string> names;
    for (const MotionChannel& channel : out.channels) {
      const auto c = static_cast<std::size_t>(channel.channel);
      if (channel.whiteness_p < by_chance && channel.u_noise > least * course_.size[c] &&
          !shows_drive(rig_.channels[c]))
        names.push_back(rig_.channels[c].name);
    }
    return names;
  }

  // Whether no channel has more noise than from reading to reading. A table that is read often enough asks for none,
  // however it moves; a wrong chain makes its own channels noisy, or the table's.
  [[nodiscard]] bool only_noise(const MotionEstimate& out) const {
    return std::all_of(out.channels.begin(), out.channels.end(), [&](const MotionChannel& channel) {
      const auto c = static_cast<std::size_t>(channel.channel);
      return channel.u_noise <= kMoreThanNoise * course_.noise[c];
    });
  }

  void refuse_contradicted(MotionEstimate& out) {
    const std::vector<std::string> names = not_white(out, kContradicted, kDigits);
    if (names.empty()) return;
    if (only_noise(out) && white_with_inflated_noise()) {
      noise_may_hide_ = strange_;
      return;
    }
    out.contradicted = true;
    out.reason = "the chain of the rig file does not explain " + listed(names);
  }

  // Whether the residuals of the chain's channels are noise once the process noise of the table is inflated. The
  // process is to blame for them then, not the chain.
  [[nodiscard]] bool white_with_inflated_noise() const {
    const MotionCourse inflated = with_inflated_process_noise(rig_, course_);
    if (!inflated.fit.converged) return false;
    const auto given = innovations_given_table(inflated.model(rig_), inflated.data, inflated.fit.at);
    return std::all_of(given.begin(), given.end(), [](const auto& innovations) {
      return innovations.empty() || whiteness_of(innovations).p >= kContradicted;
    });
  }

  // The information overstates where the innovations are not white. The sandwich form then takes its place, never
  // narrower, if there are kFewestBlocks; with fewer only the warning says it. Where the table moves as its process
  // does not have it, what comes of that through the chain cannot be told from a chain that is wrong. Residuals δ that
  // are nobody's noise move a coefficient by no more than u √(Σ δ²/S) (Cauchy and Schwarz).
  void widen(MotionEstimate& out) {
    noise_grows(1 + pattern_);
    const std::vector<std::string> names = not_white(out, kNotWhite, 0.0);
    if (names.empty()) return;
    noise_grows(1 + noise_may_hide_);
    const bool enough = course_.fit.pass.blocks >= kFewestBlocks;
    const bool widened = (enough && widen_by_blocks()) || noise_may_hide_ > 0;
    out.warnings.push_back("the residuals of " + listed(names) + " are not white: " +
                           (widened  ? "uncertainties are widened"
                            : enough ? "the scatter from block to block asks for no wider uncertainties"
                                     : "the readings are too few to say how much wider the uncertainties should be"));
  }
  // Returns whether any variance has grown.
  bool widen_by_blocks() {
    const MatrixXd& inverse = course_.fit.covariance;
    const MatrixXd sandwich = inverse * course_.fit.pass.meat * inverse;
    bool widened = false;
    for (Index i = 0; i < coefficients_; ++i) {
      const double wider = std::max(0.0, sandwich(i, i) - noise_(i, i));
      noise_(i, i) += wider;
      covariance_(i, i) += wider;
      widened = widened || wider > 0.0;
    }
    return widened;
  }

  // The term that moves the coefficients most, beside their own uncertainty.
  void widen_by(const std::vector<MissingTerm>& missing) {
    double most = 0.0;
    for (const MissingTerm& term : missing) {
      if (static_cast<Index>(term.moves.size()) != coefficients_) continue;
      const VectorXd moves = Eigen::Map<const VectorXd>(term.moves.data(), coefficients_);
      const double far = moves.cwiseAbs2().cwiseQuotient(covariance_.diagonal()).sum();
      if (!(far > most)) continue;
      most = far;
      moves_ = moves;
      moved_by_ = term.what;
    }
    if (moves_.size() > 0) covariance_ += moves_ * moves_.transpose();
  }

  // The part of noise in all variances.
  void noise_grows(double factor) {
    const MatrixXd more = noise_ * (factor - 1);
    noise_ += more;
    covariance_ += more;
  }

  void add_elements(MotionEstimate& out) {
    std::vector<Index> reported;
    for (int k = 1; k <= rig_.element_count(); ++k) {
      out.elements.push_back(element(k));
      if (out.elements.back().identifiable) {
        reported.push_back(2 * (k - 1));
        reported.push_back(2 * (k - 1) + 1);
      }
    }
    for (Index i = 0; i < coefficients_; ++i) out.u_of_noise.push_back(std::sqrt(noise_(i, i)));
    for (const Index i : reported)
      for (const Index j : reported) out.covariance.push_back(covariance_(i, j));
  }

  [[nodiscard]] Coefficient coefficient(Index i) const {
    Coefficient out;
    out.value = theta(i);
    out.u = std::sqrt(covariance_(i, i));
    const double share = noise_(i, i) / covariance_(i, i);
    out.dof = std::max(1.0, reading_count() - static_cast<double>(course_.fit.covariance.rows())) / (share * share);
    out.U95 = student_t95(out.dof) * out.u;
    out.significant = std::abs(out.value) >= out.u;
    return out;
  }

  [[nodiscard]] ElementEstimate element(int k) const {
    const Index c = 2 * (k - 1), r = c + 1;
    const double omega = kTwoPi * rig_.excitation.frequency_hz;
    ElementEstimate out;
    out.k = k;
    out.deformation = {pass_.deformation(k - 1), pass_.deformation_u(k - 1)};
    const Coefficient stiffness = coefficient(c), damping = coefficient(r);
    const double size = std::hypot(stiffness.value, omega * damping.value);
    const double u = std::hypot(stiffness.u, omega * damping.u);
    const VectorXd& undetermined = course_.fit.undetermined;
    if (undetermined(c) + undetermined(r) > 1e-6) {
      out.reason = "the readings do not determine it";
    } else if (!(u < size / 3)) {
      out.reason = "its uncertainty is " + (size > 0 ? percent(u / size) : "all") + " of its dynamic stiffness";
    } else if (!(stiffness.value > 0)) {
      out.reason = "its stiffness came out below zero: check the rig file, or wait for more readings";
    } else if (!(damping.value > damping.U95)) {
      // A mode that hides in the noise is found by one of its peaks, with next to no damping: a maximum beside the true
      // one, whose curvature tells nothing of the distance.
      out.reason = "its damping is not distinguishable from zero, so the estimate may rest on a peak of the noise";
    } else {
      out.identifiable = true;
      out.stiffness = stiffness;
      out.damping = damping;
      const double eta = omega * damping.value / stiffness.value;
      out.loss_factor = {eta, std::abs(eta) * std::hypot(stiffness.u / stiffness.value, damping.u / damping.value)};
      out.budget = budget(c);
    }
    return out;
  }

  // Of the coefficients in rows c and c + 1.
  [[nodiscard]] std::vector<BudgetShare> budget(Index c) const {
    std::vector<BudgetShare> out;
    const auto add = [&](BudgetShare source, double of_stiffness, double of_damping) {
      if (!(of_stiffness > 0) && !(of_damping > 0)) return;
      source.stiffness_share = of_stiffness;
      source.damping_share = of_damping;
      out.push_back(std::move(source));
    };
    add({.source = "noise", .kind = SourceKind::noise}, noise_(c, c), noise_(c + 1, c + 1));
    for (Index s = 0; s < by_stated_.cols(); ++s)
      add(source_of(rig_, course_.parameters[static_cast<std::size_t>(free_ + s)]),
          std::max(0.0, by_stated_(c, s) * of_stated_(c, s)),
          std::max(0.0, by_stated_(c + 1, s) * of_stated_(c + 1, s)));
    if (moves_.size() > 0)
      add({.source = moved_by_ + ", missing"}, moves_(c) * moves_(c), moves_(c + 1) * moves_(c + 1));
    double stiffness = 0.0, damping = 0.0;
    for (const BudgetShare& share : out) {
      stiffness += share.stiffness_share;
      damping += share.damping_share;
    }
    for (BudgetShare& share : out) {
      share.stiffness_share /= stiffness;
      share.damping_share /= damping;
    }
    std::stable_sort(out.begin(), out.end(), [](const BudgetShare& a, const BudgetShare& b) {
      return a.stiffness_share + a.damping_share > b.stiffness_share + b.damping_share;
    });
    return out;
  }

  const Rig& rig_;
  const MotionCourse& course_;
  Index coefficients_, free_;
  Pass pass_;
  double strange_ = 0.0;         // Whiteness::squares of the chain's channels that are not white, beyond chance
  double noise_may_hide_ = 0.0;  // the same, where the chain is not to blame
  double pattern_ = 0.0;         // the same, of the table's channels whose readings err in a pattern
  std::vector<std::vector<MotionInnovation>> given_table_;
  MatrixXd noise_, covariance_;     // of (c_1, r_1, …): the part of noise; all of it
  VectorXd moves_;                  // of (c, r) by the term that is missing; empty: none is
  std::string moved_by_;            // its name
  MatrixXd by_stated_, of_stated_;  // ∂(c, r)/∂stated, and that times the covariance of the stated
};

// Names what the rig file lacks; where the chain is refused, with the reason.
void name_missing(const Rig& rig, const MotionData& data, const MotionCourse& course, std::size_t most, bool anew,
                  MotionEstimate& out) {
  const bool refused = !out.reason.empty();
  MissingTerms found = find_missing(rig, data, course, refused, most, anew);
  out.anew = found.anew;
  if (!found.terms.empty()) {
    const double by = found.terms.front().gain;
    const std::string with = told_together(found.terms),
                      gain = std::isfinite(by) ? " (gain " + brief(by, 3) + ")" : std::string();
    if (refused)
      out.reason += "; " + with + " explains it" + gain + " and is not applied: check the rig file";
    else
      out.warnings.push_back("the readings are better explained with " + with + gain +
                             ": uncertainties are widened by what it would change");
  } else if (refused && found.anew == AnewSearch::put_off) {
    out.reason += kLookedForLater;
  } else if (refused && course.reason.empty()) {
    out.reason +=
        ", and none of the terms tried explains it: masses, scales, delays, springs and dampers to ground, springs "
        "beside the chain, " +
        std::string(found.tried_inputs ? "friction, cubic springs, " : "") + "signs, swapped channels. " +
        (found.untried > 0 ? std::to_string(found.untried) + " of these were not tried, for want of time. " : "") +
        "Check the readings and the rig file";
  }
  if (!refused && found.anew == AnewSearch::put_off)
    out.warnings.push_back(std::string("a coefficient came out below zero") + kLookedForLater);
  out.missing = std::move(found.terms);
  out.unchecked = std::move(found.unchecked);
}

// Takes the place of name_missing() where readings are at fault. A dwell withholds such a channel, or leaves out what
// is foreign in it, but the estimate of any motion uses it as it comes, so its reason or a warning says so. The
// residuals of such readings are no evidence against the chain. So `contradicted` is cleared, and the dwell's own
// numbers are not doubted.
void blame_readings(const std::vector<ChannelFault>& at_fault, MotionEstimate& out) {
  out.contradicted = false;
  std::string text;
  for (const ChannelFault& fault : at_fault) text += (text.empty() ? "" : "; ") + fault.what;
  text = "the readings themselves are at fault, so nothing that the rig file lacks is looked for: " + text;
  if (out.reason.empty())
    out.warnings.push_back(std::move(text));
  else
    out.reason += "; " + text;
}

}  // namespace

MotionEstimate estimate_motion(const Rig& rig, const MotionData& data, const MotionOptions& options) {
  MotionEstimate none;
  none.reason = "there are no readings";
  if (data.readings.empty()) return none;
  const auto states = static_cast<std::size_t>(MotionModel(rig, {}).states());
  const std::size_t most = options.most_work / states;
  const MotionCourse course = run_course(rig, data, most, {}, options.stop);
  none.reason = course.reason;
  if (course.data.readings.empty()) return none;
  Report report(rig, course);
  MotionEstimate out = report.judge();
  if (options.missing && course.fit.at.theta.size() > 0) {
    if (options.at_fault.empty())
      name_missing(rig, data, course, most, options.anew, out);
    else
      blame_readings(options.at_fault, out);
  }
  if (out.reason.empty() && !out.channels.empty()) report.give_elements(out.missing, out);
  return out;
}

}  // namespace dwell
