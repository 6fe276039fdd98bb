#include "core/chain/mode_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/complex.hpp"
#include "core/base/wording.hpp"
#include "core/chain/identify.hpp"
#include "core/chain/mode_residual.hpp"
#include "core/fit/drive_harmonic.hpp"
#include "core/model/natural_modes.hpp"
#include "core/rig/transducer.hpp"
#include "core/transient/pole_distance.hpp"

namespace dwell {
namespace {

using Eigen::Index;

constexpr int kMostMasses = 24;  // larger chains are not checked: eigenvectors cost over 5 ms, ten times a second
// False-alarm rate of one evaluation, all modes together. A dwell is evaluated some ten times with new data, so normal
// errors would raise one false doubt in 10⁵ dwells. The study doubts six of 8000 healthy dwells.
constexpr double kFalseAlarm = 1e-6;
constexpr double kSameMode = 0.2;       // relative distance: a pole farther from every eigenvalue is not the chain's
constexpr double kMissing = 1.0 / 3;    // a mode is missing in a channel below this part of its expected amplitude
constexpr double kExplains = 0.3;       // part of the contradiction (√χ²) that a single fault may leave unexplained
constexpr double kLargestError = 0.5;   // largest relative error of a mass or reading that is named as a cause
constexpr std::size_t kMostCauses = 3;  // largest number of causes named

// One mode of the data, the chain's mode that belongs to it, and the residual of the chain's equations.
struct Pair {
  const SeenMode* seen;
  const NaturalMode* natural;  // nullptr: the chain does not oscillate
  ModeResidual residual;
  double by_chance = 1.0;  // probability of such a residual by chance
};

// Amplitude of a mode in a channel's reading, up to a factor that all channels share; transducers' filters ignored.
double shown(const Rig& rig, const ElementsResult& identified, double omega, const NaturalMode& mode, Index c) {
  const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
  const auto place = [&](int at) { return at > 0 ? mode.shape(at - 1) : Complex{}; };
  if (channel.measures == Quantity::auxiliary) return 0.0;
  if (channel.measures == Quantity::force) {
    const Complex Z = identified.Z.back();
    return std::abs((stiffness(Z) + mode.pole * damping(Z, omega)) * place(rig.mass_count()));
  }
  const Complex moves = place(channel.at) - (channel.relative_to ? place(*channel.relative_to) : Complex{});
  return std::abs(moves * std::pow(mode.pole, derivative_order(channel.measures)));
}

// Whether another channel should show the mode plainly but does not: then the bracket of one transducer rings.
bool of_one_channel(const Rig& rig, const ElementsResult& identified, double omega, const SeenMode& seen,
                    const NaturalMode& mode) {
  Index most = 0;
  double stands_out = 0.0;
  for (Index c = 0; c < seen.amplitude.size(); ++c)
    if (seen.fitted[static_cast<std::size_t>(c)] && std::abs(seen.amplitude(c)) > stands_out * seen.u_amplitude(c))
      stands_out = std::abs(seen.amplitude(c)) / seen.u_amplitude(c), most = c;
  const double factor = std::abs(seen.amplitude(most)) / shown(rig, identified, omega, mode, most);
  for (Index c = 0; c < seen.amplitude.size(); ++c) {
    const double expected = factor * shown(rig, identified, omega, mode, c);
    if (seen.fitted[static_cast<std::size_t>(c)] && expected > sigmas::kPlain * seen.u_amplitude(c) &&
        std::abs(seen.amplitude(c)) < kMissing * expected)
      return true;
  }
  return false;
}

// One statement of the rig file that may be wrong.
struct Cause {
  enum class Kind { mass, scale, delay, spring, damper } kind;
  Index at;          // index of mass or channel, from 0; for a connection its first place, 0 the table
  int to = kGround;  // for a connection: its second place
};

Eigen::VectorXd force_by(const Cause& cause, const ModeResidual& residual) {
  switch (cause.kind) {
    case Cause::Kind::mass:
      return residual.by_mass(cause.at);
    case Cause::Kind::scale:
      return residual.by_scale(cause.at);
    case Cause::Kind::delay:
      return residual.by_delay(cause.at);
    default:
      return residual.by_connection(static_cast<int>(cause.at), cause.to, cause.kind == Cause::Kind::damper);
  }
}

std::string place_text(int place) {
  return place == kGround ? "ground" : place == 0 ? "the table" : "mass " + std::to_string(place);
}

std::string told(const Cause& cause, double size, const Rig& rig) {
  const std::string way = size > 0 ? " too large" : " too small";
  const double a = std::abs(size);
  const bool rotates = rig.motion == Motion::rotation;
  switch (cause.kind) {
    case Cause::Kind::mass:
      return "mass " + std::to_string(cause.at + 1) + " stated " + percent(a) + way;
    case Cause::Kind::scale:
      return rig.channels[static_cast<std::size_t>(cause.at)].name + " reading " + percent(a) + way;
    case Cause::Kind::delay:
      return rig.channels[static_cast<std::size_t>(cause.at)].name + " " + brief(1e3 * a, 2) + " ms" +
             (size > 0 ? " late" : " early");
    case Cause::Kind::spring:
      return "a spring of " + brief(a) + (rotates ? " N·m/rad" : " N/m") + " from " +
             place_text(static_cast<int>(cause.at)) + " to " + place_text(cause.to);
    default:
      return "a damper of " + brief(a) + (rotates ? " N·m·s/rad" : " N·s/m") + " from " +
             place_text(static_cast<int>(cause.at)) + " to " + place_text(cause.to);
  }
}

// All single faults that are tried as an explanation.
std::vector<Cause> faults(const Rig& rig) {
  std::vector<Cause> all;
  const int n = rig.mass_count();
  const auto connect = [&](int from, int to) {
    for (const auto kind : {Cause::Kind::spring, Cause::Kind::damper}) all.push_back({kind, from, to});
  };
  for (int k = 1; k <= n; ++k) {
    all.push_back({Cause::Kind::mass, k - 1});
    if (k < n || rig.boundary == Boundary::free) connect(k, kGround);
    for (int from = 0; from < k - 1; ++from) connect(from, k);
  }
  for (std::size_t c = 0; c < rig.channels.size(); ++c)
    for (const auto kind : {Cause::Kind::scale, Cause::Kind::delay}) all.push_back({kind, static_cast<Index>(c)});
  return all;
}

// Names the single faults that would explain all modes, likeliest first. Each fault's size is its least-squares fit.
std::string causes(const std::vector<Pair>& pairs, const Rig& rig) {
  struct Found {
    Cause cause;
    double size, left;
  };
  std::vector<Found> found;
  double whole = 0.0;
  for (const Pair& pair : pairs) whole += pair.residual.chi2();
  for (const Cause& cause : faults(rig)) {
    double information = 0.0, score = 0.0;
    for (const Pair& pair : pairs) {
      const Eigen::VectorXd by = force_by(cause, pair.residual);
      information += pair.residual.product(by, by);
      score += pair.residual.product(by, pair.residual.scaled_residual());
    }
    if (!(information > 0)) continue;
    const double size = score / information;
    const bool pulls = cause.kind == Cause::Kind::spring || cause.kind == Cause::Kind::damper;
    const bool relative = cause.kind == Cause::Kind::mass || cause.kind == Cause::Kind::scale;
    if ((pulls && size < 0) || (relative && std::abs(size) > kLargestError)) continue;
    const double left = (whole - score * size) / whole;
    if (left < kExplains * kExplains) found.push_back({cause, size, left});
  }
  std::stable_sort(found.begin(), found.end(), [](const Found& a, const Found& b) { return a.left < b.left; });
  std::string text;
  const std::size_t named = std::min(found.size(), kMostCauses);
  for (std::size_t i = 0; i < named; ++i)
    text += (i == 0 ? "" : i + 1 == named ? " or " : ", ") + told(found[i].cause, found[i].size, rig);
  return text;
}

// Says by how much the worst element differs between oscillation and drive; empty: no single element contradicts.
std::string worst_element(const Pair& pair, const Rig& rig, double omega) {
  double chi2 = 0.0;
  const Index worst = pair.residual.worst(&chi2);
  if (std::exp(-0.5 * chi2) > kFalseAlarm) return "";
  const auto e = static_cast<std::size_t>(pair.residual.elements()[static_cast<std::size_t>(worst)]);
  const Eigen::Vector2d change = pair.residual.change(worst);
  const Eigen::Matrix2d covariance = pair.residual.change_covariance(worst);
  const bool rotates = rig.motion == Motion::rotation;
  const std::string c_unit = rotates ? "N·m/rad" : "N/m", r_unit = rotates ? "N·m·s/rad" : "N·s/m";
  const auto apart = [&](Index i, const std::string& unit) {
    return plus_minus(std::abs(change(i)), 2 * std::sqrt(covariance(i, i)), unit) + (change(i) > 0 ? " more" : " less");
  };
  return "by this oscillation element " + std::to_string(e + 1) + " has " + apart(0, c_unit) + " and " +
         apart(1, r_unit) + " than by the drive at " + brief(omega / kTwoPi, 4) + " Hz";
}

std::string message(const Pair& pair, const std::vector<Pair>& pairs, const Rig& rig, double omega) {
  const Complex seen = pair.seen->pole, natural = pair.natural->pole;
  char mode[160];
  std::snprintf(mode, sizeof mode,
                "mode at %.5g Hz, decaying at %.3g /s (the identified chain: %.5g Hz, %.3g /s): ", seen.imag() / kTwoPi,
                -seen.real(), natural.imag() / kTwoPi, -natural.real());
  const std::string element = worst_element(pair, rig, omega), single = causes(pairs, rig);
  const int last = rig.element_count();
  return mode +
         (element.empty() ? "the difference exceeds the uncertainty of c and r of " +
                                (last == 1 ? std::string("element 1") : "elements 1 … " + std::to_string(last))
                          : element) +
         "; " +
         (single.empty()
              ? "check masses, units, delays and connections of the rig file, and whether an element is not linear"
              : "possible causes: " + single + ", or an element that is not linear");
}

// Names of the channels that show a mode plainly. able: the number of channels that could. Those on the table cannot,
// since its motion is imposed.
std::vector<std::string> shown_by(const Rig& rig, const SeenMode& mode, std::size_t& able) {
  std::vector<std::string> names;
  able = 0;
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    const Channel& channel = rig.channels[c];
    if (channel.measures == Quantity::auxiliary || (channel.at == 0 && !channel.relative_to)) continue;
    ++able;
    const auto i = static_cast<Index>(c);
    if (mode.fitted[c] && std::abs(mode.amplitude(i)) > sigmas::kPlain * mode.u_amplitude(i))
      names.push_back(channel.name);
  }
  return names;
}

// Which of the drive's harmonics beyond those fitted this is; 0: none.
int harmonic_of(const Rig& rig, const SeenMode& mode, double omega) {
  const double u = std::sqrt(mode.pole_covariance()(1, 1));
  return unfitted_harmonic(mode.pole.imag(), omega, 3 * u, rig.excitation.harmonics);
}

// The table's own harmonic makes all channels swing, as a mode of the chain does. It speaks against no chain.
void warn_of_harmonic(const Rig& rig, const SeenMode& mode, int harmonic, Dwell& dwell) {
  std::size_t able = 0;
  const std::vector<std::string> names = shown_by(rig, mode, able);
  if (names.empty()) return;
  dwell.warnings.push_back({WarningKind::drive_harmonic,
                            "harmonic " + std::to_string(harmonic) + " of the drive, at " +
                                brief(mode.pole.imag() / kTwoPi, 4) + " Hz, shows in " + listed(names) +
                                " and is not fitted: set excitation.harmonics to " +
                                std::to_string(std::min(harmonic, kMaxHarmonics)),
                            {},
                            names});
}

// Adds a doubt for an oscillation that the identified chain does not have. Two channels must show it plainly, or the
// only one that can: the ringing bracket of a transducer shows in one channel alone.
void doubt_foreign_mode(const Rig& rig, const std::vector<NaturalMode>& natural, const SeenMode& mode, Dwell& dwell) {
  std::size_t able = 0;
  const std::vector<std::string> channels = shown_by(rig, mode, able);
  if (channels.size() < std::min<std::size_t>(2, able) || channels.empty()) return;
  const auto nearer = [&](const auto& a, const auto& b) {
    return std::abs(a.pole - mode.pole) < std::abs(b.pole - mode.pole);
  };
  const auto nearest = std::min_element(natural.begin(), natural.end(), nearer);
  const int last = rig.element_count();
  dwell.doubts.push_back(
      {{},
       "mode at " + brief(mode.pole.imag() / kTwoPi, 4) + " Hz: the transient in " + listed(channels) +
           " shows it, decaying at " + brief(-mode.pole.real()) + " /s, and the identified chain (" +
           (last == 1 ? std::string("element 1") : "elements 1 … " + std::to_string(last)) + ") " +
           (nearest == natural.end() ? "does not oscillate by itself"
                                     : "has none there; its nearest is at " + brief(nearest->pole.imag() / kTwoPi, 4) +
                                           " Hz, decaying at " + brief(-nearest->pole.real()) + " /s") +
           ": look at units, signs, instants, masses and their order, and what else is connected"});
}

}  // namespace

void check_modes(const Rig& rig, const ElementsResult& identified, double omega, std::span<const SeenMode> seen,
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
  const SeenMode* foreign = nullptr;  // a mode that the chain does not have
  for (const SeenMode& mode : seen) {
    const auto nearer = [&](const auto& a, const auto& b) {
      return std::abs(a.pole - mode.pole) < std::abs(b.pole - mode.pole);
    };
    const auto own = std::min_element(natural.begin(), natural.end(), nearer);
    const bool none = own == natural.end();
    const bool far = none || std::abs(own->pole - mode.pole) > kSameMode * std::abs(own->pole);
    // Of several poles near one eigenvalue only the nearest belongs to the chain.
    if (!far && std::any_of(seen.begin(), seen.end(), [&](const SeenMode& other) {
          return std::abs(other.pole - own->pole) < std::abs(mode.pole - own->pole);
        }))
      continue;
    if (!far && of_one_channel(rig, identified, omega, mode, *own)) continue;
    const double widens = none ? 1.0 : overstated_distance(mode.pole, own->pole, mode.seen_s);
    Pair pair{&mode, none ? nullptr : &*own, ModeResidual(rig, identified, omega, mode, widens)};
    // The factor 2 is for two tests: of pole and shape together, and of the pole alone.
    pair.by_chance = 2 * std::min(pair.residual.by_chance(), none ? 1.0 : pair.residual.pole_by_chance(own->shape));
    if (!far)
      pairs.push_back(std::move(pair));
    else if (const int harmonic = harmonic_of(rig, mode, omega); harmonic > 0)
      warn_of_harmonic(rig, mode, harmonic, dwell);
    else if ((none || own->pole.real() < 0) && pair.by_chance * static_cast<double>(seen.size()) < kFalseAlarm)
      foreign = &mode;
  }
  if (pairs.empty()) {
    if (foreign) doubt_foreign_mode(rig, natural, *foreign, dwell);
    return;
  }
  const auto worst = std::min_element(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return a.by_chance < b.by_chance || (a.by_chance == b.by_chance && a.residual.chi2() > b.residual.chi2());
  });
  if (worst->by_chance * static_cast<double>(pairs.size()) < kFalseAlarm)
    dwell.doubts.push_back({{}, message(*worst, pairs, rig, omega)});
}

}  // namespace dwell
