#include "core/chain/identify.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <vector>

#include "tests/core/closed_forms.hpp"

namespace dwell {
namespace {

struct Case {
  std::string name;
  Boundary boundary;
  std::vector<double> masses;
  double omega;
  std::vector<Complex> Y;
  Complex F{};
  std::vector<double> c, r;
};

std::vector<Case> golden_cases() {
  std::ifstream file(DWELL_GOLDEN_DIR "/phasors.json");
  std::vector<Case> cases;
  const auto document = nlohmann::json::parse(file);
  for (const auto& json : document.at("cases")) {
    Case one;
    one.name = json.at("name");
    one.boundary = json.at("boundary") == "free" ? Boundary::free : Boundary::clamped;
    one.masses = json.at("masses_kg").get<std::vector<double>>();
    one.omega = 2 * std::numbers::pi * json.at("frequency_hz").get<double>();
    for (const auto& y : json.at("displacement"))
      one.Y.push_back(std::polar(y.at("amplitude_m").get<double>(), y.at("phase_rad").get<double>()));
    if (const auto& f = json.at("force_on_ground"); !f.is_null())
      one.F = std::polar(f.at("amplitude_n").get<double>(), f.at("phase_rad").get<double>());
    one.c = json.at("stiffness_n_per_m").get<std::vector<double>>();
    one.r = json.at("damping_n_s_per_m").get<std::vector<double>>();
    cases.push_back(std::move(one));
  }
  EXPECT_GT(cases.size(), 10u);
  return cases;
}

std::vector<Complex> identified(const Case& one) {
  std::vector<Complex> d;
  for (std::size_t k = 1; k < one.Y.size(); ++k) d.push_back(one.Y[k] - one.Y[k - 1]);
  std::vector<Complex> Z(one.c.size());
  identify(one.boundary, one.masses, one.omega, one.Y, d, one.F, Z);
  return Z;
}

ClosedFormInput polar(const Case& one) {
  ClosedFormInput in{
      one.boundary == Boundary::clamped, one.masses, one.omega, {}, {}, std::abs(one.F), std::arg(one.F)};
  for (const Complex& y : one.Y) in.A.push_back(std::abs(y)), in.alpha.push_back(std::arg(y));
  return in;
}

TEST(Identify, RecoversEveryGoldenCoefficientTo1e9) {
  for (const Case& one : golden_cases()) {
    const auto Z = identified(one);
    for (std::size_t k = 0; k < Z.size(); ++k) {
      EXPECT_NEAR(stiffness(Z[k]) / one.c[k], 1.0, 1e-9) << one.name << ", c_" << k + 1;
      EXPECT_NEAR(damping(Z[k], one.omega) / one.r[k], 1.0, 1e-9) << one.name << ", r_" << k + 1;
    }
  }
}

TEST(Identify, TheCorrectedClosedFormsAgree) {
  for (const Case& one : golden_cases()) {
    const auto closed = corrected_closed_forms(polar(one));
    // The closed forms subtract squares (D_k) where the phasor form subtracts phasors: they lose twice the digits.
    for (std::size_t k = 0; k < one.c.size(); ++k) {
      EXPECT_NEAR(closed[k].c / one.c[k], 1.0, 1e-6) << one.name << ", c_" << k + 1;
      EXPECT_NEAR(closed[k].r / one.r[k], 1.0, 1e-6) << one.name << ", r_" << k + 1;
    }
  }
}

TEST(Identify, TheDampingFormulas18To20AsPrintedComeOutNegative) {
  for (const Case& one : golden_cases()) {
    if (one.boundary != Boundary::free) continue;
    const auto printed = printed_free_18_to_20(polar(one));
    for (std::size_t k = 0; k < one.r.size(); ++k)
      EXPECT_LT(printed[k].r * one.r[k], 0.0) << one.name << ", r_" << k + 1;
    // (19)'s last term for c_k, cos(α_k - α_{k-1}) twice, is wrong wherever it applies (elements between the ends); in
    // a chain of 16 or more the last mass moves too little to show it.
    if (one.masses.size() > 8) continue;
    for (std::size_t k = 1; k + 1 < one.c.size(); ++k)
      EXPECT_GT(std::abs(printed[k].c / one.c[k] - 1.0), 1e-6) << one.name << ", c_" << k + 1;
  }
}

TEST(Identify, TheClampedFormulas32To35AsPrintedAreWrongForTheForceOnTheGround) {
  for (const Case& one : golden_cases()) {
    if (one.boundary != Boundary::clamped || one.masses.empty()) continue;
    const auto printed = printed_clamped_32_to_35(polar(one));
    for (std::size_t k = 0; k + 1 < one.c.size(); ++k)
      EXPECT_GT(std::hypot(printed[k].c / one.c[k] - 1.0, printed[k].r / one.r[k] - 1.0), 1e-6)
          << one.name << ", element " << k + 1;
  }
}

TEST(Identify, AnElementBetweenTableAndLoadCellIsForceOverMotion) {
  const Complex Y[] = {std::polar(2e-3, 0.3)};
  const double omega = 20.0;
  const Complex truth{5e4, omega * 30.0};
  Complex Z[1];
  identify(Boundary::clamped, {}, omega, Y, {}, truth * Y[0], Z);
  EXPECT_NEAR(stiffness(Z[0]), 5e4, 1e-8);
  EXPECT_NEAR(damping(Z[0], omega), 30.0, 1e-10);
}

}  // namespace
}  // namespace dwell
