#include "config/units.hpp"

namespace dwell::config {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kInch = 0.0254;                 // m, exact
constexpr double kFoot = 0.3048;                 // m, exact
constexpr double kPoundForce = 4.4482216152605;  // N, exact
constexpr double kOunceForce = kPoundForce / 16.0;
constexpr double kStandardGravity = 9.80665;  // m/s², exact; also N per kgf

constexpr Unit kLength[] = {{"m", 1.0},   {"cm", 1e-2},  {"mm", 1e-3},     {"um", 1e-6},
                            {"nm", 1e-9}, {"in", kInch}, {"mil", 2.54e-5}, {"ft", kFoot}};
constexpr Unit kVelocity[] = {{"m/s", 1.0},   {"cm/s", 1e-2},  {"mm/s", 1e-3},
                              {"um/s", 1e-6}, {"in/s", kInch}, {"ft/s", kFoot}};
constexpr Unit kAcceleration[] = {{"m/s2", 1.0},    {"cm/s2", 1e-2},  {"mm/s2", 1e-3},         {"um/s2", 1e-6},
                                  {"in/s2", kInch}, {"ft/s2", kFoot}, {"g", kStandardGravity}, {"mg", 9.80665e-3}};
constexpr Unit kForce[] = {{"N", 1.0},
                           {"mN", 1e-3},
                           {"kN", 1e3},
                           {"MN", 1e6},
                           {"lbf", kPoundForce},
                           {"ozf", kOunceForce},
                           {"kip", 4448.2216152605},
                           {"kgf", kStandardGravity}};
constexpr Unit kAngle[] = {{"rad", 1.0}, {"mrad", 1e-3}, {"urad", 1e-6}, {"deg", kPi / 180.0}, {"rev", 2.0 * kPi}};
constexpr Unit kAngularVelocity[] = {
    {"rad/s", 1.0}, {"mrad/s", 1e-3}, {"deg/s", kPi / 180.0}, {"rev/s", 2.0 * kPi}, {"rpm", kPi / 30.0}};
constexpr Unit kAngularAcceleration[] = {
    {"rad/s2", 1.0}, {"mrad/s2", 1e-3}, {"deg/s2", kPi / 180.0}, {"rev/s2", 2.0 * kPi}};
constexpr Unit kTorque[] = {{"N*m", 1.0},
                            {"mN*m", 1e-3},
                            {"kN*m", 1e3},
                            {"MN*m", 1e6},
                            {"N*cm", 1e-2},
                            {"N*mm", 1e-3},
                            {"lbf*in", kPoundForce* kInch},
                            {"lbf*ft", kPoundForce* kFoot},
                            {"ozf*in", kOunceForce* kInch},
                            {"kgf*m", kStandardGravity}};

template <std::size_t size>
std::vector<Unit> all(const Unit (&units)[size]) {
  return {units, units + size};
}

}  // namespace

std::vector<Unit> units_of(Quantity quantity, Motion motion) {
  const bool rotation = motion == Motion::rotation;
  switch (quantity) {
    case Quantity::displacement:
      return rotation ? all(kAngle) : all(kLength);
    case Quantity::velocity:
      return rotation ? all(kAngularVelocity) : all(kVelocity);
    case Quantity::acceleration:
      return rotation ? all(kAngularAcceleration) : all(kAcceleration);
    case Quantity::force:
      return rotation ? all(kTorque) : all(kForce);
    case Quantity::auxiliary:
      break;
  }
  return {};
}

std::optional<double> si_per_unit(Quantity quantity, Motion motion, std::string_view unit) {
  for (const Unit& known : units_of(quantity, motion)) {
    if (known.name == unit) return known.si_per_unit;
  }
  return std::nullopt;
}

std::string unit_names(Quantity quantity, Motion motion) {
  std::string names;
  for (const Unit& unit : units_of(quantity, motion)) {
    if (!names.empty()) names += ", ";
    names += unit.name;
  }
  return names;
}

const char* si_unit(Quantity quantity, Motion motion) noexcept {
  const bool rotation = motion == Motion::rotation;
  switch (quantity) {
    case Quantity::displacement:
      return rotation ? "rad" : "m";
    case Quantity::velocity:
      return rotation ? "rad/s" : "m/s";
    case Quantity::acceleration:
      return rotation ? "rad/s2" : "m/s2";
    case Quantity::force:
      return rotation ? "N*m" : "N";
    case Quantity::auxiliary:
      break;
  }
  return "";
}

const char* stiffness_unit(Motion motion) noexcept { return motion == Motion::rotation ? "N*m/rad" : "N/m"; }
const char* damping_unit(Motion motion) noexcept { return motion == Motion::rotation ? "N*m*s/rad" : "N*s/m"; }
const char* mass_unit(Motion motion) noexcept { return motion == Motion::rotation ? "kg*m2" : "kg"; }

const char* to_string(Quantity quantity) noexcept {
  switch (quantity) {
    case Quantity::displacement:
      return "displacement";
    case Quantity::velocity:
      return "velocity";
    case Quantity::acceleration:
      return "acceleration";
    case Quantity::force:
      return "force";
    case Quantity::auxiliary:
      break;
  }
  return "auxiliary";
}

const char* to_string(Motion motion) noexcept { return motion == Motion::rotation ? "rotation" : "translation"; }

}  // namespace dwell::config
