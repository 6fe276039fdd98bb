// The factors are written here in another way than in the code: by how many SI units a known number of units is.
#include "config/units.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace dwell::config {
namespace {

struct Known {
  Quantity quantity;
  Motion motion;
  const char* unit;
  double count;
  double si;  // count units are this much
};

TEST(Units, AgreeWithFactorsWrittenIndependently) {
  constexpr auto translation = Motion::translation;
  constexpr auto rotation = Motion::rotation;
  const double half_turn = std::acos(-1.0);
  const Known known[] = {
      {Quantity::displacement, translation, "m", 1, 1},
      {Quantity::displacement, translation, "cm", 100, 1},
      {Quantity::displacement, translation, "mm", 1000, 1},
      {Quantity::displacement, translation, "um", 1000000, 1},
      {Quantity::displacement, translation, "nm", 1000000000, 1},
      {Quantity::displacement, translation, "in", 5000, 127},
      {Quantity::displacement, translation, "mil", 5000000, 127},
      {Quantity::displacement, translation, "ft", 1250, 381},
      {Quantity::velocity, translation, "m/s", 1, 1},
      {Quantity::velocity, translation, "cm/s", 100, 1},
      {Quantity::velocity, translation, "mm/s", 1000, 1},
      {Quantity::velocity, translation, "um/s", 1000000, 1},
      {Quantity::velocity, translation, "in/s", 5000, 127},
      {Quantity::velocity, translation, "ft/s", 1250, 381},
      {Quantity::acceleration, translation, "m/s2", 1, 1},
      {Quantity::acceleration, translation, "cm/s2", 100, 1},
      {Quantity::acceleration, translation, "mm/s2", 1000, 1},
      {Quantity::acceleration, translation, "um/s2", 1000000, 1},
      {Quantity::acceleration, translation, "in/s2", 5000, 127},
      {Quantity::acceleration, translation, "ft/s2", 1250, 381},
      {Quantity::acceleration, translation, "g", 100000, 980665},
      {Quantity::acceleration, translation, "mg", 100000000, 980665},
      {Quantity::force, translation, "N", 1, 1},
      {Quantity::force, translation, "mN", 1000, 1},
      {Quantity::force, translation, "kN", 1, 1000},
      {Quantity::force, translation, "MN", 1, 1000000},
      {Quantity::force, translation, "lbf", 1, 0.45359237 * 9.80665},
      {Quantity::force, translation, "ozf", 16, 0.45359237 * 9.80665},
      {Quantity::force, translation, "kip", 1, 453.59237 * 9.80665},
      {Quantity::force, translation, "kgf", 1, 9.80665},
      {Quantity::displacement, rotation, "rad", 1, 1},
      {Quantity::displacement, rotation, "mrad", 1000, 1},
      {Quantity::displacement, rotation, "urad", 1000000, 1},
      {Quantity::displacement, rotation, "deg", 180, half_turn},
      {Quantity::displacement, rotation, "rev", 0.5, half_turn},
      {Quantity::velocity, rotation, "rad/s", 1, 1},
      {Quantity::velocity, rotation, "mrad/s", 1000, 1},
      {Quantity::velocity, rotation, "deg/s", 180, half_turn},
      {Quantity::velocity, rotation, "rev/s", 0.5, half_turn},
      {Quantity::velocity, rotation, "rpm", 30, half_turn},
      {Quantity::acceleration, rotation, "rad/s2", 1, 1},
      {Quantity::acceleration, rotation, "mrad/s2", 1000, 1},
      {Quantity::acceleration, rotation, "deg/s2", 180, half_turn},
      {Quantity::acceleration, rotation, "rev/s2", 0.5, half_turn},
      {Quantity::force, rotation, "N*m", 1, 1},
      {Quantity::force, rotation, "mN*m", 1000, 1},
      {Quantity::force, rotation, "kN*m", 1, 1000},
      {Quantity::force, rotation, "MN*m", 1, 1000000},
      {Quantity::force, rotation, "N*cm", 100, 1},
      {Quantity::force, rotation, "N*mm", 1000, 1},
      {Quantity::force, rotation, "lbf*in", 1, 0.1129848290276167},
      {Quantity::force, rotation, "lbf*ft", 1, 1.3558179483314004},
      {Quantity::force, rotation, "ozf*in", 1, 0.00706155181422604375},
      {Quantity::force, rotation, "kgf*m", 1, 9.80665},
  };
  std::size_t units = 0;
  for (const Quantity quantity :
       {Quantity::displacement, Quantity::velocity, Quantity::acceleration, Quantity::force}) {
    units += units_of(quantity, translation).size() + units_of(quantity, rotation).size();
  }
  EXPECT_EQ(units, std::size(known)) << "a unit that is not in this list is not tested";
  for (const Known& k : known) {
    const auto factor = si_per_unit(k.quantity, k.motion, k.unit);
    ASSERT_TRUE(factor.has_value()) << k.unit;
    EXPECT_NEAR(k.count * *factor / k.si, 1.0, 4e-16) << k.unit;  // a rounding or two
  }
}

TEST(Units, OfOneQuantityAreNotThoseOfAnother) {
  EXPECT_FALSE(si_per_unit(Quantity::displacement, Motion::translation, "N"));
  EXPECT_FALSE(si_per_unit(Quantity::displacement, Motion::translation, "rad"));
  EXPECT_FALSE(si_per_unit(Quantity::force, Motion::rotation, "N"));
  EXPECT_FALSE(si_per_unit(Quantity::auxiliary, Motion::rotation, "N"));
  EXPECT_FALSE(si_per_unit(Quantity::displacement, Motion::translation, ""));
  EXPECT_FALSE(si_per_unit(Quantity::displacement, Motion::translation, "MM"));
}

TEST(Units, OfReportsAreSI) {
  for (const Quantity quantity :
       {Quantity::displacement, Quantity::velocity, Quantity::acceleration, Quantity::force}) {
    for (const Motion motion : {Motion::translation, Motion::rotation}) {
      EXPECT_EQ(si_per_unit(quantity, motion, si_unit(quantity, motion)), 1.0);
      EXPECT_EQ(units_of(quantity, motion).front().name, si_unit(quantity, motion));
    }
  }
  EXPECT_STREQ(stiffness_unit(Motion::translation), "N/m");
  EXPECT_STREQ(stiffness_unit(Motion::rotation), "N*m/rad");
  EXPECT_STREQ(damping_unit(Motion::translation), "N*s/m");
  EXPECT_STREQ(damping_unit(Motion::rotation), "N*m*s/rad");
  EXPECT_STREQ(mass_unit(Motion::rotation), "kg*m2");
}

}  // namespace
}  // namespace dwell::config
