#include "core/motion/candidates.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/angle.hpp"

namespace dwell {
namespace {

double omega_of(const Rig& rig) { return kTwoPi * rig.excitation.frequency_hz; }

}  // namespace

std::vector<Parameter> missing_candidates(const Rig& rig) {
  std::vector<Parameter> out;
  for (int i = 0; i < rig.mass_count(); ++i)
    for (const Unknown what :
         {Unknown::mass, Unknown::ground_damping, Unknown::ground_stiffness, Unknown::ground_friction})
      out.push_back({what, i});
  for (int pair = 0; pair < static_cast<int>(apart(rig.mass_count()).size()); ++pair)
    out.push_back({Unknown::side_stiffness, pair});
  for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c)
    if (rig.channels[static_cast<std::size_t>(c)].measures != Quantity::auxiliary)
      for (const Unknown what : {Unknown::scale, Unknown::delay}) out.push_back({what, c});
  for (int e = 0; e < rig.element_count(); ++e)
    for (const Unknown what : {Unknown::friction, Unknown::cubic}) out.push_back({what, e});
  return out;
}

double natural_size(const Rig& rig, const Parameter& candidate, const ElementSizes& elements) {
  const double omega = omega_of(rig);
  const auto mass = [&] { return rig.masses[static_cast<std::size_t>(candidate.index)]; };
  const auto upper_mass = [&] {
    return rig.masses[static_cast<std::size_t>(
        apart(rig.mass_count())[static_cast<std::size_t>(candidate.index)].second - 1)];
  };
  const auto force = [&] {
    const double d = elements.deformation(candidate.index);
    return d * std::hypot(elements.stiffness(candidate.index), omega * elements.damping(candidate.index));
  };
  const double least = std::numeric_limits<double>::min();
  switch (candidate.what) {
    case Unknown::mass:
      return mass();
    case Unknown::ground_stiffness:
      return mass() * omega * omega;
    case Unknown::ground_damping:
      return mass() * omega;
    case Unknown::side_stiffness:
      return upper_mass() * omega * omega;
    case Unknown::delay:
      return 1 / omega;
    case Unknown::friction:
    case Unknown::ground_friction:
      return std::max(force(), least);
    case Unknown::cubic:
      return std::max(force(), least) / std::max(std::pow(elements.deformation(candidate.index), 3), least);
    default:
      return 1.0;
  }
}

bool is_possible(const Rig& rig, const Parameter& candidate, double value) {
  switch (candidate.what) {
    case Unknown::mass:
      return rig.masses[static_cast<std::size_t>(candidate.index)] + value > 0;
    case Unknown::ground_stiffness:
    case Unknown::ground_damping:
    case Unknown::side_stiffness:
    case Unknown::friction:
    case Unknown::ground_friction:
      return value > 0;
    case Unknown::delay:
      return std::abs(value) < 0.5 / omega_of(rig);
    case Unknown::scale:
      return value > -0.5;
    default:
      return true;
  }
}

}  // namespace dwell
