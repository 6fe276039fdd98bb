#include "core/motion/unknowns.hpp"

namespace dwell {
namespace {

// Where a rig file lets the drive be searched: ±2 % of nominal, by default. Of random motion no reading tells it.
constexpr double kDriveU = 0.02;

// Largest number of masses with which all pairs of places are tried: 28 pairs, beside 32 other terms of masses. Larger:
// the search for what is missing takes longer, as the square. Smaller: a spring past several masses is not tried.
constexpr int kAllPairs = 8;

// Of what a rig file states.
SourceKind kind_of(Unknown stated) {
  switch (stated) {
    case Unknown::scale:
      return SourceKind::scale;
    case Unknown::delay:
    case Unknown::device_delay:
      return SourceKind::delay;
    case Unknown::lowpass:
      return SourceKind::lowpass;
    case Unknown::highpass:
      return SourceKind::highpass;
    case Unknown::mass:
      return SourceKind::mass;
    case Unknown::clock:
      return SourceKind::clock_rate;
    case Unknown::drive:
      return SourceKind::frequency;
    default:
      return SourceKind::other;
  }
}

}  // namespace

std::vector<std::pair<int, int>> apart(int masses) {
  std::vector<std::pair<int, int>> out;
  for (int a = 0; a + 2 <= masses; ++a)
    for (int b = a + 2; b <= (masses <= kAllPairs ? masses : a + 2); ++b) out.emplace_back(a, b);
  return out;
}

std::string between(const std::pair<int, int>& places) {
  const auto [a, b] = places;
  return "between " + (a == 0 ? std::string("the table") : "mass " + std::to_string(a)) + " and mass " +
         std::to_string(b);
}

std::vector<Parameter> free_parameters(const Rig& rig, int stretches) {
  std::vector<Parameter> out;
  for (int e = 0; e < rig.element_count(); ++e) {
    out.push_back({Unknown::stiffness, e});
    out.push_back({Unknown::damping, e});
  }
  for (int i = 0; i < stretches; ++i) out.push_back({Unknown::intensity, i});
  for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c)
    if (rig.channels[static_cast<std::size_t>(c)].measures != Quantity::auxiliary) out.push_back({Unknown::noise, c});
  out.push_back({Unknown::drive, 0, kDriveU});
  return out;
}

std::vector<Parameter> stated_parameters(const Rig& rig) {
  std::vector<Parameter> out;
  const auto add = [&out](Unknown what, std::size_t index, double u) {
    if (u > 0.0) out.push_back({what, static_cast<int>(index), u});
  };
  for (std::size_t i = 0; i < rig.mass_u.size(); ++i) add(Unknown::mass, i, rig.mass_u[i]);
  std::vector<bool> used(rig.devices.size(), false);
  for (std::size_t c = 0; c < rig.channels.size(); ++c) {
    const Channel& channel = rig.channels[c];
    if (channel.measures == Quantity::auxiliary) continue;
    if (channel.device >= 0) used[static_cast<std::size_t>(channel.device)] = true;
    add(Unknown::scale, c, channel.scale_u);
    add(Unknown::delay, c, channel.delay_u_s);
    if (channel.lowpass.kind != FilterKind::none) add(Unknown::lowpass, c, channel.lowpass.hz_u);
    if (channel.highpass.kind != FilterKind::none) add(Unknown::highpass, c, channel.highpass.hz_u);
  }
  for (std::size_t d = 0; d < rig.devices.size(); ++d)
    if (used[d]) add(Unknown::device_delay, d, rig.devices[d].delay_u_s);
  add(Unknown::clock, 0, rig.excitation.clock_u);
  return out;
}

std::string name_of(const Rig& rig, const Parameter& parameter) {
  const auto i = static_cast<std::size_t>(parameter.index);
  const auto number = [&] { return std::to_string(parameter.index + 1); };
  switch (parameter.what) {
    case Unknown::stiffness:
      return "stiffness " + number();
    case Unknown::damping:
      return "damping " + number();
    case Unknown::intensity:
      return "motion of the table";
    case Unknown::drive:
      return "frequency of the drive";
    case Unknown::noise:
      return "noise of " + rig.channels[i].name;
    case Unknown::mass:
      return "mass " + number();
    case Unknown::scale:
      return "scale of " + rig.channels[i].name;
    case Unknown::delay:
      return "delay of " + rig.channels[i].name;
    case Unknown::device_delay:
      return "delay of " + rig.devices[i].name;
    case Unknown::lowpass:
      return "low-pass of " + rig.channels[i].name;
    case Unknown::highpass:
      return "high-pass of " + rig.channels[i].name;
    case Unknown::clock:
      return "clock rate";
    case Unknown::ground_stiffness:
      return "spring of mass " + number() + " to ground";
    case Unknown::ground_damping:
      return "damping of mass " + number() + " to ground";
    case Unknown::side_stiffness:
      return "spring " + between(apart(rig.mass_count())[i]);
    case Unknown::friction:
      return "friction in element " + number();
    case Unknown::ground_friction:
      return "friction of mass " + number() + " to ground";
    case Unknown::cubic:
      return "cubic stiffness of element " + number();
  }
  return {};
}

BudgetShare source_of(const Rig& rig, const Parameter& stated) {
  BudgetShare source{.source = name_of(rig, stated), .kind = kind_of(stated.what)};
  const auto i = static_cast<std::size_t>(stated.index);
  if (stated.what == Unknown::mass)
    source.mass = stated.index + 1;
  else if (stated.what == Unknown::device_delay)
    source.device = rig.devices[i].name;
  else if (stated.what != Unknown::clock && stated.what != Unknown::drive)
    source.channel = rig.channels[i].name;
  return source;
}

}  // namespace dwell
