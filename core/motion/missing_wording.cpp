#include "core/motion/missing_wording.hpp"

#include <cmath>

#include "core/base/student.hpp"
#include "core/base/wording.hpp"

namespace dwell {
namespace {

// Per unit of the chain's motion, m or rad.
std::string force_per(const Rig& rig, const char* translation, const char* rotation) {
  return rig.motion == Motion::rotation ? rotation : translation;
}

std::string unit_of(const Rig& rig, const Parameter& term) {
  switch (term.what) {
    case Unknown::mass:
      return force_per(rig, "kg", "kg*m2");
    case Unknown::ground_stiffness:
    case Unknown::side_stiffness:
      return force_per(rig, "N/m", "N*m/rad");
    case Unknown::ground_damping:
      return force_per(rig, "N*s/m", "N*m*s/rad");
    case Unknown::friction:
    case Unknown::ground_friction:
      return force_per(rig, "N", "N*m");
    case Unknown::cubic:
      return force_per(rig, "N/m3", "N*m/rad3");
    case Unknown::delay:
      return "s";
    default:
      return "1";
  }
}

std::string in_words(const Rig& rig, const Parameter& term, const MissingTerm& of) {
  const auto i = static_cast<std::size_t>(term.index);
  const std::string unit = of.unit == "1" ? "" : unit_text(of.unit);
  std::string number = plus_minus(of.value, kNormal95 * of.u, unit);
  while (!number.empty() && number.back() == ' ') number.pop_back();
  const std::string mass = std::to_string(term.index + 1);
  switch (term.what) {
    case Unknown::mass:
      return "a mass " + mass + " of " + number + " instead of " + brief(rig.masses[i], 6) + " " + unit;
    case Unknown::delay:
      return "a delay of " + rig.channels[i].name + " of " + plus_minus(1e3 * of.value, 1e3 * kNormal95 * of.u, "ms") +
             " instead of " + brief(1e3 * rig.channels[i].delay_s, 6) + " ms";
    case Unknown::scale:
      return "a scale of " + rig.channels[i].name + " of " + number + " instead of " + brief(rig.channels[i].scale, 6);
    case Unknown::ground_damping:
      return "a damper of " + number + " from mass " + mass + " to ground";
    case Unknown::ground_stiffness:
      return "a spring of " + number + " from mass " + mass + " to ground";
    case Unknown::side_stiffness:
      return "a spring of " + number + " " + between(apart(rig.mass_count())[i]);
    case Unknown::friction:
      return "friction of " + number + " in element " + mass;
    case Unknown::ground_friction:
      return "friction of " + number + " between mass " + mass + " and ground";
    default:
      return "a cubic stiffness of " + number + " of element " + mass;
  }
}

}  // namespace

MissingTerm missing_term(const Rig& rig, const Parameter& term, double departure, double u, double gain) {
  const auto i = static_cast<std::size_t>(term.index);
  MissingTerm out;
  out.what = name_of(rig, term);
  out.value = departure;
  out.u = u;
  out.unit = unit_of(rig, term);
  out.gain = gain;
  if (term.what == Unknown::mass) out.value += rig.masses[i];
  if (term.what == Unknown::delay) out.value += rig.channels[i].delay_s;
  if (term.what == Unknown::scale) {  // the channel shows (1 + departure) times as much
    out.value = rig.channels[i].scale / (1 + departure);
    out.u = std::abs(out.value / (1 + departure)) * u;
  }
  out.told = in_words(rig, term, out);
  return out;
}

std::string told_together(const std::vector<MissingTerm>& terms) {
  std::string text;
  for (const MissingTerm& term : terms) text += (text.empty() ? "" : " or ") + term.told;
  return text;
}

}  // namespace dwell
