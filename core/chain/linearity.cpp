#include "core/chain/linearity.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/student.hpp"
#include "core/base/wording.hpp"
#include "core/chain/chain_state.hpp"
#include "core/chain/identify.hpp"
#include "core/rig/transducer.hpp"

namespace dwell {
namespace {

using Eigen::VectorXcd;
using Index = Eigen::Index;

// An element is far from linear if a harmonic exceeds this part of its force, whatever the change of c and r: the
// harmonic linearization assumes small harmonics.
constexpr double kFarFromLinear = 0.1;

// Part of an element's third harmonic that a channel's distortion may leave unexplained: a distortion that is not small
// has higher harmonics too. With half of it a transducer that saturates at twice its amplitude, tanh(½)/½, is not
// named. As it is, no single element with friction or hardening blames a channel in the tests.
constexpr double kSameDistortion = 0.4;

// Error of the fundamental over harmonic 2, where a law or a transducer is larger by the part g for one sign: g/2 over
// 2g/(3π).
constexpr double kOneSided = 0.75 * std::numbers::pi;

// The chain at harmonic h, and what each channel observes there.
struct Harmonic {
  int h;
  ChainState chain;
  VectorXcd seen;  // displacement or force on the ground
};

Harmonic harmonic_of(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence, double omega, int h) {
  VectorXcd seen = VectorXcd::Zero(gain.gain.cols());
  for (Index c = 0; c < seen.size(); ++c) {
    const Evidence& of = evidence[static_cast<std::size_t>(c)];
    if (of.usable) seen(c) = as_observed(rig, static_cast<int>(c), of.X[static_cast<std::size_t>(h - 1)], omega, h);
  }
  VectorXcd x = gain.gain * seen;
  return {h, {rig, rig.mass_count(), h * omega, std::move(x)}, std::move(seen)};
}

// Relative variance of a channel's phasor at ω by systematic errors: scale, instants, filters.
double stated_variance(const Rig& rig, std::size_t c, const Evidence& of, double omega) {
  const Channel& channel = rig.channels[c];
  const Device device = channel.device >= 0 ? rig.devices[static_cast<std::size_t>(channel.device)] : Device{};
  const LogSlopes slopes = response_slopes(channel, device.delay_s, omega / kTwoPi);
  const double delay_u = std::hypot(std::hypot(channel.delay_u_s, of.refresh_u_s, of.uneven.own_s), device.delay_u_s,
                                    std::hypot(of.turnaround_u_s, of.uneven.shared_s));
  return channel.scale_u * channel.scale_u + of.uneven.part * of.uneven.part + std::pow(omega * delay_u, 2) +
         std::norm(slopes.lowpass_corner) * channel.lowpass.hz_u * channel.lowpass.hz_u +
         std::norm(slopes.highpass_corner) * channel.highpass.hz_u * channel.highpass.hz_u;
}

// Residual e_h of an element's force at one harmonic, after subtracting (c + jhωr) d_h; N.
struct Excess {
  Complex force;  // e_h, relative to the phase of the deformation
  double sure;    // limit per component: more than this is not noise
  // Change of `force`, per ρ, if a channel adds ρ times its fundamental as this harmonic. For harmonic 3 (y - βy³, ρ =
  // βa²/4) it includes the error of c and r, since the fundamental loses 3ρ. For harmonic 2 the loss is not known, and
  // left out.
  VectorXcd by_channel;
};

// Error of c + jhωr, per ρ, if channel c loses 3ρ of its fundamental X.
Complex lost_by(const Rig& rig, const Gain& gain, const Harmonic& first, const ElementEstimate& element, Index c,
                Complex X, int h) {
  const double omega = first.chain.omega;
  const Complex Z{element.stiffness.value, omega * element.damping.value};
  const VectorXcd deformation = first.chain.deformation_row(element.k);
  const VectorXcd row = first.chain.force_row(element.k) - Z * deformation;
  const Complex read = as_observed(rig, static_cast<int>(c), -3.0 * X, omega, 1);
  const Complex dZ = row.cwiseProduct(gain.gain.col(c)).sum() * read / deformation.cwiseProduct(first.chain.x).sum();
  return {dZ.real(), h * dZ.imag()};
}

Excess excess_of(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence, const Frequency& frequency,
                 const Harmonic& first, const Harmonic& at, const ElementEstimate& element, double phase_rad) {
  const double omega = at.chain.omega;
  const Complex Z{element.stiffness.value, omega * element.damping.value};
  const VectorXcd deformation = at.chain.deformation_row(element.k);
  const VectorXcd row = at.chain.force_row(element.k) - Z * deformation;
  const auto times_x = [&](const VectorXcd& function) { return function.cwiseProduct(at.chain.x).sum(); };
  double variance =
      std::norm(times_x(deformation)) * (std::pow(element.stiffness.u, 2) + std::pow(omega * element.damping.u, 2));
  double least_dof = std::numeric_limits<double>::infinity();
  VectorXcd by_channel = VectorXcd::Zero(at.seen.size());
  for (Index c = 0; c < at.seen.size(); ++c) {
    const auto i = static_cast<std::size_t>(c);
    const Evidence& of = evidence[i];
    if (!of.usable || !gain.uses(row, c)) continue;
    const Complex per_reading = as_observed(rig, static_cast<int>(c), 1.0, frequency.omega, at.h);
    const Complex part = row.cwiseProduct(gain.gain.col(c)).sum();
    // The scatter of the fundamental (of.widened) does not apply to this harmonic.
    // A held register's instants drift as polls and refreshes beat, which may repeat with the motion: any harmonic.
    const double noise = 0.5 * (of.covariance + of.transient).trace() + of.quantization_u * of.quantization_u +
                         0.5 * std::norm(frequency.omega * of.refresh_u_s * of.X[0]);
    if (at.h == 3)
      by_channel(c) -= lost_by(rig, gain, first, element, c, of.X[0], at.h) * times_x(deformation) *
                       std::polar(1.0, -at.h * phase_rad);
    // Where y = |X| sin φ, y² and a gain that differs between the halves add -cos 2φ, and -y³ adds sin 3φ.
    const double adds_rad = at.h == 2 ? -0.5 * std::numbers::pi : 0.0;
    by_channel(c) +=
        part * per_reading * std::abs(of.X[0]) * std::polar(1.0, at.h * (std::arg(of.X[0]) - phase_rad) + adds_rad);
    variance += std::norm(part * per_reading) * noise;
    variance += std::norm(part * at.seen(c)) * stated_variance(rig, i, of, omega);
    least_dof = std::min(least_dof, of.dof);
  }
  for (std::size_t i = static_cast<std::size_t>(element.k - 1); i < rig.mass_u.size(); ++i)
    variance += std::norm(omega * omega * rig.mass_u[i] * at.chain.Y(static_cast<int>(i) + 1));
  const double clock = 2 * std::hypot(frequency.u / frequency.omega, frequency.clock_u);
  variance += std::norm(times_x(at.chain.force_row(element.k))) * clock * clock;
  // With few degrees of freedom the noise estimate is itself uncertain.
  const double few = std::pow(student_t95(least_dof) / kNormal95, 2);
  return {times_x(row) * std::polar(1.0, -at.h * phase_rad), sigmas::kSure * few * std::sqrt(variance),
          std::move(by_channel)};
}

// Channels whose distortion alone explains a harmonic of all elements.
struct Distortion {
  std::vector<std::string> channels;
  std::string text;  // empty: there are none
};

// told: the elements that show harmonic h.
Distortion distorting(const Rig& rig, int h, const std::vector<Excess>& excesses, const std::vector<int>& told) {
  Distortion out;
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    const auto i = static_cast<Index>(c);
    double overlap = 0.0, power = 0.0;
    for (const Excess& excess : excesses) {
      overlap += (std::conj(excess.by_channel(i)) * excess.force).real() / (excess.sure * excess.sure);
      power += std::norm(excess.by_channel(i)) / (excess.sure * excess.sure);
    }
    if (!(power > 0)) continue;
    const double part = overlap / power;
    const bool explains = std::all_of(excesses.begin(), excesses.end(), [&](const Excess& excess) {
      return std::abs(excess.force - part * excess.by_channel(i)) <
             std::max(excess.sure, kSameDistortion * std::abs(excess.force));
    });
    if (!explains) continue;
    out.channels.push_back(rig.channels[c].name);
    out.text += (out.text.empty() ? "if " : ", or if ") + rig.channels[c].name + " distorts, a harmonic " +
                std::to_string(h) + " of " + percent(std::abs(part)) +
                (h == 3 ? " in phase with its reading explains " : " of its reading explains ") + elements_text(told) +
                "; its reading " +
                (h == 3 ? "is then " + percent(3 * std::abs(part)) + (part > 0 ? " too small" : " too large")
                        : "may then be wrong by " + percent(kOneSided * std::abs(part)) +
                              ", as with a gain that differs between the halves of the motion");
  }
  if (!out.text.empty()) out.text += ": check its range and its amplifier";
  return out;
}

// Parts of c and r that come from the nonlinearity seen in a harmonic.
struct Parts {
  double in_c = 0.0, in_r = 0.0;                      // N/m, N·s/m
  bool significant_c = false, significant_r = false;  // the part is significant and exceeds the coefficient's U95
  [[nodiscard]] bool significant() const { return significant_c || significant_r; }
};

Parts explained_by(const Excess& third, const ElementEstimate& element, double omega) {
  const double a = element.deformation.value, elastic = third.force.real(), dissipative = third.force.imag();
  Parts parts;
  parts.in_c = -3 * elastic / a;
  parts.in_r = (dissipative < 0 ? -3 : 5) * dissipative / (omega * a);
  parts.significant_c = std::abs(elastic) > third.sure && std::abs(parts.in_c) > element.stiffness.U95;
  parts.significant_r = std::abs(dissipative) > third.sure && std::abs(parts.in_r) > element.damping.U95;
  return parts;
}

// By harmonic 2, if the law differs between the signs. Springs and dampers both make an imaginary e_2.
Parts one_sided(const Excess& second, const ElementEstimate& element, double omega) {
  const double a = element.deformation.value, size = std::abs(second.force.imag());
  Parts parts;
  parts.in_c = kOneSided * size / a;
  parts.in_r = parts.in_c / omega;
  parts.significant_c = size > second.sure && parts.in_c > element.stiffness.U95;
  parts.significant_r = size > second.sure && parts.in_r > element.damping.U95;
  return parts;
}

std::string equivalent_words(const Rig& rig, const ElementEstimate& element, const Parts& parts, bool is_far) {
  return "element " + std::to_string(element.k) + (is_far ? " is far from linear: " : " is not linear: ") +
         (parts.significant_c && parts.significant_r
              ? "its c and r are equivalent stiffness and equivalent damping at this amplitude"
          : parts.significant_c ? "its c is an equivalent stiffness at this amplitude"
                                : "its r is an equivalent damping at this amplitude") +
         " (" + brief(element.deformation.value) + (rig.motion == Motion::rotation ? " rad" : " m") +
         "). c and r do not explain harmonic ";
}

std::string words_of_second(const Rig& rig, const ElementEstimate& element, const Excess& second, const Parts& parts,
                            bool is_far) {
  const double U = second.sure * kNormal95 / sigmas::kSure;
  return equivalent_words(rig, element, parts, is_far) + "2 of its force: " +
         plus_minus(std::abs(second.force.imag()), U, rig.motion == Motion::rotation ? "N·m" : "N") +
         ". A spring that is stiffer one way than the other would explain it, and " +
         brief(100 * parts.in_c / std::abs(element.stiffness.value), 2) + " % of c; or a damper like that, and " +
         brief(100 * parts.in_r / std::abs(element.damping.value), 2) +
         " % of r. Measure at other amplitudes; a transducer that distorts gives the same picture";
}

std::string words_of(const Rig& rig, const ElementEstimate& element, const Excess& third, const Parts& parts,
                     double omega, bool is_far) {
  const bool turns = rig.motion == Motion::rotation;
  const std::string newton = turns ? "N·m" : "N";
  const double a = element.deformation.value, U = third.sure * kNormal95 / sigmas::kSure;
  const double elastic = third.force.real(), dissipative = third.force.imag();
  std::string text = equivalent_words(rig, element, parts, is_far) +
                     "3 of its force: " + plus_minus(std::abs(dissipative), U, newton) +
                     " in phase with the velocity (damping force " + brief(omega * element.damping.value * a) + " " +
                     newton + "), " + plus_minus(std::abs(elastic), U, newton) +
                     " in phase with the deformation (spring force " + brief(element.stiffness.value * a) + " " +
                     newton + "). ";
  if (std::abs(dissipative) < std::abs(elastic))
    text += std::string("A spring that ") + (elastic < 0 ? "hardens" : "softens") +
            " with the cube of the deformation would explain it, and " +
            brief(100 * std::abs(parts.in_c / element.stiffness.value), 2) + " % of c";
  else if (dissipative < 0)
    text += "Friction of about " + brief(0.75 * std::numbers::pi * -dissipative, 2) + " " + newton +
            " would explain it, and " + brief(100 * std::abs(parts.in_r / element.damping.value), 2) + " % of r";
  else
    text += "Damping with the square of the velocity would explain it, and " +
            brief(100 * std::abs(parts.in_r / element.damping.value), 2) + " % of r";
  return text + ". Measure at other amplitudes; a transducer that distorts gives the same picture";
}

}  // namespace

Linearity judge_linearity(const Rig& rig, const Gain& gain, const std::vector<Evidence>& evidence,
                          const Frequency& frequency, const std::vector<ElementEstimate>& elements) {
  std::vector<Harmonic> harmonics;
  for (int h = 1; h <= rig.excitation.harmonics; ++h)
    harmonics.push_back(harmonic_of(rig, gain, evidence, frequency.omega, h));
  Linearity out;
  const auto warn = [&](std::string what, int k) {
    out.warnings.push_back({WarningKind::nonlinear, std::move(what), {k}, {}});
  };
  std::vector<Excess> seconds, thirds;  // of all elements
  std::vector<int> with_second, with_third;
  for (const ElementEstimate& element : elements) {
    if (!element.identifiable) continue;
    const ChainState& chain = harmonics.front().chain;
    const Complex d = chain.deformation_row(element.k).cwiseProduct(chain.x).sum();
    const double omega = frequency.omega;
    const double force = std::hypot(element.stiffness.value, omega * element.damping.value) * std::abs(d);
    double worst = kFarFromLinear;
    int worst_h = 0;
    Excess second{{}, INFINITY, {}}, third{{}, INFINITY, {}};
    for (std::size_t i = 1; i < harmonics.size(); ++i) {
      const Excess excess =
          excess_of(rig, gain, evidence, frequency, harmonics.front(), harmonics[i], element, std::arg(d));
      if (harmonics[i].h == 2) second = excess;
      if (harmonics[i].h == 3) third = excess;
      const double size = std::abs(excess.force);
      if (size > excess.sure && size > worst * force) worst = size / force, worst_h = harmonics[i].h;
    }
    if (std::isfinite(second.sure)) seconds.push_back(second);
    if (std::isfinite(third.sure)) thirds.push_back(third);
    const Parts by_second = one_sided(second, element, omega), by_third = explained_by(third, element, omega);
    if (by_second.significant()) with_second.push_back(element.k);
    if (by_third.significant()) with_third.push_back(element.k);
    if (by_third.significant()) warn(words_of(rig, element, third, by_third, omega, worst_h == 3), element.k);
    if (by_second.significant()) warn(words_of_second(rig, element, second, by_second, worst_h == 2), element.k);
    if (worst_h > 0 && !by_third.significant() && !by_second.significant())
      warn("element " + std::to_string(element.k) + " is far from linear: harmonic " + std::to_string(worst_h) +
               " of its force that c and r do not explain is " + brief(100 * worst, 2) +
               " % of the fundamental; c and r are equivalent stiffness and damping at this amplitude",
           element.k);
  }
  // With one element, its own nonlinearity and a channel's distortion cannot be told apart.
  if (with_third.size() > 1)
    if (Distortion by = distorting(rig, 3, thirds, with_third); !by.text.empty())
      out.doubts.push_back({with_third, std::move(by.text)});
  if (with_second.size() > 1)
    if (Distortion by = distorting(rig, 2, seconds, with_second); !by.text.empty())
      out.warnings.push_back({WarningKind::nonlinear, std::move(by.text), with_second, std::move(by.channels)});
  return out;
}

}  // namespace dwell
