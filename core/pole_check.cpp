#include "core/pole_check.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "core/angle.hpp"
#include "core/identify.hpp"
#include "core/natural_modes.hpp"
#include "core/transducer.hpp"
#include "core/wording.hpp"

namespace dwell {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;

constexpr int kMostMasses = 24;         // beyond, the eigenvectors ten times a second cost more than 5 ms
constexpr double kFalseAlarm = 1e-5;    // of one evaluation, all modes together
constexpr double kSameMode = 0.2;       // relative: a pole farther from every eigenvalue is none of the chain's
constexpr double kPlain = 8.0;          // standard deviations: an amplitude that cannot be overlooked …
constexpr double kMissing = 1.0 / 3;    // … and the part of it below which it is not there
constexpr double kNonlinear = 16.0;     // of an eigenvalue's variance: what first order may miss of a shift that large
constexpr double kExplains = 0.3;       // of the contradiction, that a single fault may leave over
constexpr double kFirstOrder = 0.05;    // relative: a pole shifted farther is not explained by derivatives
constexpr std::size_t kMostCauses = 3;  // that are named

// One mode of the data and the eigenvalue that it belongs to.
struct Pair {
  const SeenMode* seen;
  const NaturalMode* natural;
  Eigen::Vector2d shift;
  Eigen::Matrix2d covariance;  // of the shift
  Eigen::Matrix2d of_chain;    // the eigenvalue's part of it
  double chi2;
};

Eigen::Vector2d real_pair(Complex z) { return {z.real(), z.imag()}; }

// How much a channel shows of a natural oscillation, up to a common factor; the transducer's own filter left aside.
double shown(const Rig& rig, const ElementsResult& identified, double omega, const NaturalMode& mode, std::size_t c) {
  const Channel& channel = rig.channels[c];
  const auto place = [&](int at) { return at > 0 ? mode.shape(at - 1) : Complex{}; };
  if (channel.measures == Quantity::auxiliary) return 0.0;
  if (channel.measures == Quantity::force) {
    const Complex Z = identified.Z.back();
    return std::abs((stiffness(Z) + mode.pole * damping(Z, omega)) * place(rig.mass_count()));
  }
  const Complex moves = place(channel.at) - (channel.relative_to ? place(*channel.relative_to) : Complex{});
  return std::abs(moves * std::pow(mode.pole, derivative_order(channel.measures)));
}

// What one channel shows and another that ought to show it does not, is that channel's own: its bracket rings.
bool of_one_channel(const Rig& rig, const ElementsResult& identified, double omega, const SeenMode& seen,
                    const NaturalMode& mode) {
  std::size_t most = 0;
  double stands_out = 0.0;
  for (std::size_t c = 0; c < seen.amplitude.size(); ++c)
    if (seen.u_amplitude[c] > 0 && seen.amplitude[c] > stands_out * seen.u_amplitude[c])
      stands_out = seen.amplitude[c] / seen.u_amplitude[c], most = c;
  const double factor = seen.amplitude[most] / shown(rig, identified, omega, mode, most);
  for (std::size_t c = 0; c < seen.amplitude.size(); ++c) {
    const double expected = factor * shown(rig, identified, omega, mode, c);
    if (seen.u_amplitude[c] > 0 && expected > kPlain * seen.u_amplitude[c] && seen.amplitude[c] < kMissing * expected)
      return true;
  }
  return false;
}

// δλ by changes of the coefficients [c_1, r_1, …].
Complex moved_by(const NaturalMode& mode, const Eigen::VectorXd& coefficients) {
  Complex sum{};
  for (Index e = 0; e < mode.by_stiffness.size(); ++e)
    sum += mode.by_stiffness(e) * (coefficients(2 * e) + mode.pole * coefficients(2 * e + 1));
  return sum;
}

// The same by changes of Z.
Complex moved_by(const NaturalMode& mode, const Eigen::VectorXcd& Z, double omega) {
  Complex sum{};
  for (Index e = 0; e < mode.by_stiffness.size(); ++e)
    sum += mode.by_stiffness(e) * (Z(e).real() + mode.pole * Z(e).imag() / omega);
  return sum;
}

Eigen::Matrix2d covariance_of(const NaturalMode& mode, const ElementsResult& identified, double omega) {
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  const Index elements = mode.by_stiffness.size();
  Eigen::VectorXd variance = Eigen::VectorXd::Zero(2 * elements);
  for (const SourceEffect& effect : identified.effects) {
    if (effect.of_clock) continue;
    Complex moved = moved_by(mode, effect.on_coefficients);
    if (effect.mass > 0) moved += mode.by_mass(effect.mass - 1) * effect.mass_u;
    covariance += real_pair(moved) * real_pair(moved).transpose();
    variance += effect.on_coefficients.cwiseAbs2();
  }
  // To second order: an element known to u(Z)/|Z| is moved by that part of what it is moved by to first order.
  for (Index e = 0; e < elements; ++e) {
    const double u_Z = std::hypot(std::sqrt(variance(2 * e)), omega * std::sqrt(variance(2 * e + 1)));
    const double again =
        std::abs(mode.by_stiffness(e)) * u_Z * u_Z / std::abs(identified.Z[static_cast<std::size_t>(e)]);
    covariance += again * again * Eigen::Matrix2d::Identity();
  }
  return covariance;
}

// A single fault of what the rig file says, and the shift of a mode that a unit of it makes.
struct Cause {
  enum class Kind { mass, scale, delay, spring, damper } kind;
  Index at;  // of mass or channel, from 0
};

Complex shift_by(const Cause& cause, const NaturalMode& mode, const Rig& rig, const ElementsResult& identified,
                 double omega) {
  const auto through = [&](const Eigen::VectorXcd& Z) { return moved_by(mode, Z, omega); };
  switch (cause.kind) {
    case Cause::Kind::scale:
      return -through(identified.by_channel.col(cause.at));
    case Cause::Kind::delay:
      return -through(identified.by_channel.col(cause.at) * Complex{0.0, -omega});
    default:
      break;
  }
  // A mass feels inertia s² m; a spring to ground is its like with 1, a damper with s, in place of s² (s = jω as
  // identified, s = λ in the oscillation).
  const double mass = rig.masses[static_cast<std::size_t>(cause.at)];
  const Complex s{0.0, omega}, pole = mode.pole;
  const Eigen::VectorXcd by_force = identified.by_mass.col(cause.at) / (mass * s * s);
  const Complex at_pole = mode.by_mass(cause.at) / (pole * pole);
  switch (cause.kind) {
    case Cause::Kind::mass:
      return -(through(identified.by_mass.col(cause.at)) + mode.by_mass(cause.at) * mass);
    case Cause::Kind::spring:
      return at_pole + through(by_force);
    default:
      return at_pole * pole + through(by_force * s);
  }
}

std::string told(const Cause& cause, double size, const Rig& rig) {
  const std::string mass = "mass " + std::to_string(cause.at + 1);
  const std::string way = size > 0 ? " too large" : " too small";
  const double a = std::abs(size);
  switch (cause.kind) {
    case Cause::Kind::mass:
      return mass + " stated " + percent(a) + way;
    case Cause::Kind::scale:
      return rig.channels[static_cast<std::size_t>(cause.at)].name + " reading " + percent(a) + way;
    case Cause::Kind::delay:
      return rig.channels[static_cast<std::size_t>(cause.at)].name + " " + brief(1e3 * a, 2) + " ms" +
             (size > 0 ? " late" : " early");
    case Cause::Kind::spring:
      return "a spring of " + brief(a) + " " + (rig.motion == Motion::rotation ? "N·m/rad" : "N/m") + " from " + mass +
             " to ground";
    default:
      return "a damper of " + brief(a) + " " + (rig.motion == Motion::rotation ? "N·m·s/rad" : "N·s/m") + " from " +
             mass + " to ground";
  }
}

// What single fault would explain the shifts of all modes, likeliest first.
std::string causes(const std::vector<Pair>& pairs, const Rig& rig, const ElementsResult& identified, double omega) {
  struct Found {
    Cause cause;
    double size, left;
  };
  std::vector<Found> found;
  double whole = 0.0;
  for (const Pair& pair : pairs) {
    whole += pair.chi2;
    if (pair.shift.norm() > kFirstOrder * std::abs(pair.natural->pole)) return {};
  }
  const auto try_cause = [&](Cause cause) {
    double information = 0.0, score = 0.0;
    for (const Pair& pair : pairs) {
      const Eigen::Vector2d by = real_pair(shift_by(cause, *pair.natural, rig, identified, omega));
      const Eigen::Vector2d weighted = pair.covariance.llt().solve(by);
      information += by.dot(weighted);
      score += pair.shift.dot(weighted);
    }
    if (!(information > 0)) return;
    const double size = score / information;
    const bool pulls = cause.kind == Cause::Kind::spring || cause.kind == Cause::Kind::damper;
    if (pulls && size < 0) return;
    const double left = (whole - score * size) / whole;
    if (left < kExplains * kExplains) found.push_back({cause, size, left});
  };
  for (Index k = 0; k < rig.mass_count(); ++k)
    for (const auto kind : {Cause::Kind::mass, Cause::Kind::spring, Cause::Kind::damper}) try_cause({kind, k});
  for (Index c = 0; c < identified.by_channel.cols(); ++c)
    for (const auto kind : {Cause::Kind::scale, Cause::Kind::delay}) try_cause({kind, c});
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.left < b.left; });
  std::string text;
  for (std::size_t i = 0; i < std::min(found.size(), kMostCauses); ++i)
    text += (i == 0                                         ? ""
             : i + 1 == std::min(found.size(), kMostCauses) ? " or "
                                                            : ", ") +
            told(found[i].cause, found[i].size, rig);
  return text;
}

// The element and the channel on which the mode depends most.
std::string most_depends(const Pair& pair, const Rig& rig, const ElementsResult& identified, double omega) {
  Index element = 0, channel = 0;
  double most = 0.0;
  for (Index e = 0; e < pair.natural->by_stiffness.size(); ++e)
    if (const double by = std::abs(pair.natural->by_stiffness(e) * identified.Z[static_cast<std::size_t>(e)]);
        by > most)
      most = by, element = e;
  most = 0.0;
  for (Index c = 0; c < identified.by_channel.cols(); ++c)
    if (const double by = std::abs(moved_by(*pair.natural, identified.by_channel.col(c), omega)); by > most)
      most = by, channel = c;
  return "it depends most on element " + std::to_string(element + 1) + " and " +
         rig.channels[static_cast<std::size_t>(channel)].name;
}

std::string message(const Pair& pair, const std::vector<Pair>& pairs, const Rig& rig, const ElementsResult& identified,
                    double omega) {
  const Eigen::Matrix2d& seen = pair.seen->covariance;
  const int last = rig.element_count();
  const std::string chain = last == 1 ? "element 1" : "elements 1 … " + std::to_string(last);
  char text[300];
  std::snprintf(text, sizeof text,
                "mode at %.4g Hz: the transient shows %.5g ± %.2g Hz, decaying at %.3g ± %.2g /s; the identified "
                "chain (%s) has %.5g ± %.2g Hz, %.3g ± %.2g /s; ",
                pair.seen->pole.imag() / kTwoPi, pair.seen->pole.imag() / kTwoPi, 2 * std::sqrt(seen(1, 1)) / kTwoPi,
                -pair.seen->pole.real(), 2 * std::sqrt(seen(0, 0)), chain.c_str(), pair.natural->pole.imag() / kTwoPi,
                2 * std::sqrt(pair.of_chain(1, 1)) / kTwoPi, -pair.natural->pole.real(),
                2 * std::sqrt(pair.of_chain(0, 0)));
  const std::string single = causes(pairs, rig, identified, omega);
  return text +
         (single.empty()
              ? "look for a mass, a unit, a delay, or a connection that the rig file does not have, or an element that "
                "is not linear: " +
                    most_depends(pair, rig, identified, omega)
              : "this would be explained by " + single + ", or by an element that is not linear");
}

// How many channels show a mode plainly, of those that can show one of the chain: all but the table's, which is
// imposed.
std::string shown_by(const Rig& rig, const SeenMode& mode, std::size_t& count, std::size_t& able) {
  std::vector<std::string> names;
  able = 0;
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    const Channel& channel = rig.channels[c];
    if (channel.measures == Quantity::auxiliary || (channel.at == 0 && !channel.relative_to)) continue;
    ++able;
    if (mode.amplitude[c] > kPlain * mode.u_amplitude[c] && mode.u_amplitude[c] > 0) names.push_back(channel.name);
  }
  count = names.size();
  return listed(names);
}

// An oscillation that the identified chain does not have at all, and that several channels show plainly (or the only
// one that can): a bracket of one transducer that rings is told from it by that.
void doubt_foreign_mode(const Rig& rig, const std::vector<NaturalMode>& natural, const SeenMode& mode, Dwell& dwell) {
  std::size_t count = 0, able = 0;
  const std::string names = shown_by(rig, mode, count, able);
  if (count < std::min<std::size_t>(2, able) || count == 0) return;
  const auto nearer = [&](const auto& a, const auto& b) {
    return std::abs(a.pole - mode.pole) < std::abs(b.pole - mode.pole);
  };
  const auto nearest = std::min_element(natural.begin(), natural.end(), nearer);
  const int last = rig.element_count();
  dwell.doubts.push_back({{},
                          "mode at " + brief(mode.pole.imag() / kTwoPi, 4) + " Hz: the transient in " + names +
                              " shows it, decaying at " + brief(-mode.pole.real()) + " /s, and the identified chain (" +
                              (last == 1 ? std::string("element 1") : "elements 1 … " + std::to_string(last)) +
                              ") has none there; its nearest is at " + brief(nearest->pole.imag() / kTwoPi, 4) +
                              " Hz, decaying at " + brief(-nearest->pole.real()) +
                              " /s: look at units, signs, masses and their order, and what else is connected"});
}

}  // namespace

void check_poles(const Rig& rig, const ElementsResult& identified, double omega, std::span<const SeenMode> seen,
                 Dwell& dwell) {
  if (seen.empty() || rig.mass_count() > kMostMasses) return;
  Chain chain{rig.boundary, rig.masses, {}, {}};
  for (const Complex Z : identified.Z) {
    chain.stiffness.push_back(stiffness(Z));
    chain.damping.push_back(damping(Z, omega));
  }
  if (!chain.fault().empty()) return;
  const std::vector<NaturalMode> natural = natural_modes(chain);
  std::vector<Pair> pairs;
  const SeenMode* foreign = nullptr;  // none of the chain's
  for (const SeenMode& mode : seen) {
    const auto nearer = [&](const auto& a, const auto& b) {
      return std::abs(a.pole - mode.pole) < std::abs(b.pole - mode.pole);
    };
    const auto own = std::min_element(natural.begin(), natural.end(), nearer);
    if (own == natural.end()) continue;
    if (std::abs(own->pole - mode.pole) > kSameMode * std::abs(own->pole)) {
      // Where the elements are hardly known the eigenvalues are neither.
      const Eigen::LLT<Eigen::Matrix2d> off(kNonlinear * covariance_of(*own, identified, omega) + mode.covariance);
      const Eigen::Vector2d shift = real_pair(mode.pole - own->pole);
      if (own->pole.real() < 0 && off.info() == Eigen::Success &&
          shift.dot(off.solve(shift)) > 2 * std::log(1 / kFalseAlarm))
        foreign = &mode;
      continue;
    }
    // Of two poles near one eigenvalue the nearer one is the chain's.
    if (std::any_of(seen.begin(), seen.end(), [&](const SeenMode& other) {
          return std::abs(other.pole - own->pole) < std::abs(mode.pole - own->pole);
        }))
      continue;
    if (of_one_channel(rig, identified, omega, mode, *own)) continue;
    Pair pair{&mode, &*own, real_pair(mode.pole - own->pole), {}, covariance_of(*own, identified, omega), 0.0};
    const bool far = std::abs(own->pole - mode.pole) > kFirstOrder * std::abs(own->pole);
    pair.covariance = (far ? kNonlinear : 1.0) * pair.of_chain + mode.covariance;
    const Eigen::LLT<Eigen::Matrix2d> llt(pair.covariance);
    if (llt.info() != Eigen::Success) continue;
    pair.chi2 = pair.shift.dot(llt.solve(pair.shift));
    if (std::isfinite(pair.chi2)) pairs.push_back(pair);
  }
  if (pairs.empty()) {
    if (foreign) doubt_foreign_mode(rig, natural, *foreign, dwell);
    return;
  }
  const auto worst =
      std::max_element(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.chi2 < b.chi2; });
  // χ² of two degrees of freedom exceeds x with probability exp(-x/2).
  if (worst->chi2 > 2 * std::log(static_cast<double>(pairs.size()) / kFalseAlarm))
    dwell.doubts.push_back({{}, message(*worst, pairs, rig, identified, omega)});
}

}  // namespace dwell
