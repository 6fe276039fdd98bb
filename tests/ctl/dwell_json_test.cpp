#include "daemon/report/dwell_json.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <complex>
#include <limits>

#include "daemon/report/dwell_json_value.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell {
namespace {

std::vector<std::string> names_of(const Json& object) {
  std::vector<std::string> names;
  for (const auto& [name, value] : object.items()) names.push_back(name);
  return names;
}

Json sample_json() { return json_value(make_view(test::sample_dwell(), test::sample_rig(), test::sample_run())); }

using Names = std::vector<std::string>;

// The names are the interface's; `settling_reason`, `memory_time_predicted_s`, `u_relative_phase_rad`, `sigma`,
// `samples`, `valid`, `kind`, `channel`, `warned`, `doubts`, `unstated`, `motion_reason`, `model` extend it.
TEST(DwellJson, HasTheFieldsOfTheInterfaceAndTheirNames) {
  const Json dwell = sample_json();
  EXPECT_EQ(names_of(dwell), (Names{"index",        "state",           "start_s",
                                    "settled_s",    "verdict_s",       "end_s",
                                    "start_utc",    "memory_time_s",   "memory_time_predicted_s",
                                    "settles_in_s", "settling_reason", "rig_sha256",
                                    "version",      "frequency_hz",    "t_ref_s",
                                    "phasors",      "elements",        "covariance",
                                    "warnings",     "warned",          "doubts",
                                    "unstated",     "motion",          "motion_reason",
                                    "model"}));
  EXPECT_EQ(names_of(dwell["frequency_hz"]), (Names{"value", "u"}));
  EXPECT_EQ(names_of(dwell["phasors"][0]),
            (Names{"channel", "unit", "amplitude", "phase_rad", "u_amplitude", "u_phase_rad", "u_relative_phase_rad",
                   "mean", "harmonics", "sigma", "samples", "valid"}));
  const Json& element = dwell["elements"][0];
  EXPECT_EQ(names_of(element),
            (Names{"k", "identifiable", "deformation", "stiffness", "damping", "loss_factor", "budget"}));
  EXPECT_EQ(names_of(element["deformation"]), (Names{"amplitude", "u", "unit"}));
  EXPECT_EQ(names_of(element["stiffness"]), (Names{"value", "u", "dof", "U95", "significant", "unit"}));
  EXPECT_EQ(names_of(element["damping"]), names_of(element["stiffness"]));
  EXPECT_EQ(names_of(element["loss_factor"]), (Names{"value", "u"}));
  EXPECT_EQ(names_of(element["budget"][0]), (Names{"source", "kind", "channel", "stiffness_share", "damping_share"}));
}

TEST(DwellJson, CarriesTheValuesWithTheirUnits) {
  const Json dwell = sample_json();
  EXPECT_EQ(dwell["index"], 1);
  EXPECT_EQ(dwell["state"], "measuring");
  EXPECT_EQ(dwell["settled_s"], 6.42);
  EXPECT_TRUE(dwell["settles_in_s"].is_null());
  EXPECT_EQ(dwell["start_utc"], "2026-11-21T08:00:00Z");
  EXPECT_EQ(dwell["rig_sha256"], "ab12");
  EXPECT_EQ(dwell["frequency_hz"]["value"], 4.0003);
  EXPECT_NEAR(dwell["phasors"][0]["amplitude"].get<double>(), 0.005, 1e-17);
  EXPECT_NEAR(dwell["phasors"][0]["phase_rad"].get<double>(), 0.25, 1e-15);
  EXPECT_EQ(dwell["phasors"][1]["unit"], "m/s2");
  EXPECT_EQ(dwell["phasors"][3]["unit"], "N");
  EXPECT_EQ(dwell["elements"][0]["stiffness"]["U95"], 27.4);
  EXPECT_EQ(dwell["elements"][0]["stiffness"]["unit"], "N/m");
  EXPECT_EQ(dwell["elements"][0]["damping"]["unit"], "N*s/m");
  EXPECT_EQ(dwell["elements"][2]["damping"]["significant"], false);
  EXPECT_EQ(dwell["covariance"].size(), 4U);
  EXPECT_EQ(dwell["covariance"][2][2], 9920.16);
}

TEST(DwellJson, ARotatingRigSpeaksInRadiansAndNewtonMetres) {
  Rig rig = test::sample_rig();
  rig.motion = Motion::rotation;
  const Json dwell = json_value(make_view(test::sample_dwell(), rig, {}));
  EXPECT_EQ(dwell["phasors"][0]["unit"], "rad");
  EXPECT_EQ(dwell["phasors"][1]["unit"], "rad/s2");
  EXPECT_EQ(dwell["phasors"][3]["unit"], "N*m");
  EXPECT_EQ(dwell["elements"][0]["deformation"]["unit"], "rad");
  EXPECT_EQ(dwell["elements"][0]["stiffness"]["unit"], "N*m/rad");
  EXPECT_EQ(dwell["elements"][0]["damping"]["unit"], "N*m*s/rad");
}

TEST(DwellJson, AnElementThatIsNotIdentifiableHasAReasonInsteadOfNumbers) {
  const Json element = sample_json()["elements"][1];
  EXPECT_EQ(element["identifiable"], false);
  EXPECT_TRUE(element["stiffness"].is_null());
  EXPECT_TRUE(element["damping"].is_null());
  EXPECT_EQ(element["reason"], "the deformation is less than three times its uncertainty");
}

TEST(DwellJson, WithholdsTheNumbersOfAPhasorThatIsNotValid) {
  Dwell dwell = test::sample_dwell();
  dwell.phasors[0].valid = false;
  dwell.phasors[0].reason = "stale: disconnected";
  const Json phasor = json_value(make_view(dwell, test::sample_rig(), {}))["phasors"][0];
  EXPECT_TRUE(phasor["amplitude"].is_null());
  EXPECT_TRUE(phasor["mean"].is_null());
  EXPECT_EQ(phasor["reason"], "stale: disconnected");
}

TEST(DwellJson, BeforeSettlingThereAreNoElementsAndAWarningSaysWhy) {
  Dwell dwell = test::settling_dwell();
  dwell.elements = test::sample_dwell().elements;
  const Json json = json_value(make_view(dwell, test::sample_rig(), {}));
  EXPECT_TRUE(json["settled_s"].is_null());
  EXPECT_TRUE(json["elements"].empty());
  EXPECT_TRUE(json["covariance"].empty());
  ASSERT_EQ(json["warnings"].size(), 1U);
  EXPECT_EQ(json["warnings"][0], "not settled: 2.1 % of the transient of reaction is left, 0.5 % allowed");
}

TEST(DwellJson, DoubtsNameTheirElementsAndAreRepeatedAsWarningsOnce) {
  Dwell dwell = test::sample_dwell();
  dwell.doubts = {{{1, 3}, "stiffness of element 3 is negative"}, {{}, "the model contradicts the data"}};
  dwell.unstated = {"scale of y1"};
  const DwellView view = make_view(dwell, test::sample_rig(), {});
  const Json json = json_value(view);
  EXPECT_EQ(json["doubts"][0]["elements"], (Json{1, 3}));
  EXPECT_EQ(json["doubts"][1]["elements"], Json::array());
  EXPECT_EQ(json["warnings"], (Json{"stiffness of element 3 is negative", "the model contradicts the data",
                                    "channel y2 is stale: timeout"}));
  const auto back = dwell_from_json(json);
  ASSERT_TRUE(back) << back.error();
  ASSERT_EQ(back->dwell.doubts.size(), 2U);
  EXPECT_EQ(back->dwell.doubts[0].elements, (std::vector<int>{1, 3}));
  EXPECT_EQ(back->dwell.warnings, dwell.warnings);
  EXPECT_EQ(back->dwell.unstated, dwell.unstated);
}

TEST(DwellJson, AWarningTellsItsKindAndWhatItConcerns) {
  Dwell dwell = test::sample_dwell();
  dwell.doubts = {{{1, 3}, "the poles contradict the chain"}};
  dwell.warnings = {{WarningKind::nonlinear, "element 3 is not linear", {3}, {}},
                    {WarningKind::hum, "hum in y0, y1", {}, {"y0", "y1"}}};
  const Json json = json_value(make_view(dwell, test::sample_rig(), {}));
  EXPECT_EQ(json["warned"], Json::parse(R"([{"kind":"doubt","elements":[1,3],"channels":[]},
                                            {"kind":"nonlinear","elements":[3],"channels":[]},
                                            {"kind":"hum","elements":[],"channels":["y0","y1"]}])"));
  const auto back = dwell_from_json(json);
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ(back->dwell.warnings, dwell.warnings);
}

TEST(DwellJson, ADwellThatHasNotSettledSaysSoByTheKindOfItsWarning) {
  const Json json = json_value(make_view(test::settling_dwell(), test::sample_rig(), {}));
  ASSERT_EQ(json["warned"].size(), 1U);
  EXPECT_EQ(json["warned"][0]["kind"], "not settled");
}

TEST(DwellJson, AShareOfABudgetTellsItsKindAndWhoseItIs) {
  Dwell dwell = test::sample_dwell();
  dwell.elements[0].budget = {{"turnaround of amplifier (y0, y1)", 0.5, 0.5, SourceKind::turnaround, {}, "amplifier"},
                              {"mass 2", 0.3, 0.3, SourceKind::mass, {}, {}, 2},
                              {"noise of y1", 0.2, 0.2, SourceKind::noise, "y1"}};
  const Json json = json_value(make_view(dwell, test::sample_rig(), {}));
  const Json& budget = json["elements"][0]["budget"];
  EXPECT_EQ(budget[0]["kind"], "turnaround");
  EXPECT_EQ(budget[0]["device"], "amplifier");
  EXPECT_FALSE(budget[0].contains("channel"));
  EXPECT_EQ(budget[1]["kind"], "mass");
  EXPECT_EQ(budget[1]["mass"], 2);
  EXPECT_EQ(budget[2]["kind"], "noise");
  EXPECT_EQ(budget[2]["channel"], "y1");
  const auto back = dwell_from_json(json);
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ(json_value(*back)["elements"], json["elements"]);
}

// Run files of older programs are read as well.
TEST(DwellJson, AResultOfAProgramThatKnewNoKindsIsRead) {
  Json json = json_value(make_view(test::settling_dwell(), test::sample_rig(), {}));
  json.erase("warned");
  const auto settling = dwell_from_json(json);
  ASSERT_TRUE(settling) << settling.error();
  EXPECT_EQ(settling->dwell.warnings[0].kind, WarningKind::not_settled);
  json = sample_json();
  for (Json& share : json["elements"][0]["budget"]) {
    share.erase("kind");
    share.erase("channel");
  }
  const auto measured = dwell_from_json(json);
  ASSERT_TRUE(measured) << measured.error();
  EXPECT_EQ(measured->dwell.elements[0].budget[0].kind, SourceKind::other);
}

TEST(DwellJson, IdleHasNoIndexAndOnlyACompleteDwellSaysWhatEndedIt) {
  const Json idle = json_value(make_view(Dwell{}, test::sample_rig(), {}));
  EXPECT_TRUE(idle["index"].is_null());
  EXPECT_EQ(idle["state"], "idle");
  EXPECT_TRUE(idle["start_utc"].is_null());
  EXPECT_FALSE(idle.contains("ended_by"));
  Dwell dwell = test::sample_dwell();
  dwell.ended_by = EndedBy::drive_changed;
  EXPECT_FALSE(json_value(make_view(dwell, test::sample_rig(), {})).contains("ended_by"));
  dwell.state = State::complete;
  EXPECT_EQ(json_value(make_view(dwell, test::sample_rig(), {}))["ended_by"], "drive changed");
}

TEST(DwellJson, NoNumberIsNull) {
  Dwell dwell = test::sample_dwell();
  dwell.elements[0].stiffness.dof = std::numeric_limits<double>::infinity();
  dwell.elements[0].damping.value = kNaN;
  dwell.covariance[1] = kNaN;
  const std::string text = to_json(dwell, test::sample_rig(), test::sample_run());
  EXPECT_EQ(text.find("nan"), std::string::npos);
  EXPECT_EQ(text.find("inf"), std::string::npos);
  const Json json = Json::parse(text);
  EXPECT_TRUE(json["elements"][0]["stiffness"]["dof"].is_null());
  EXPECT_TRUE(json["elements"][0]["damping"]["value"].is_null());
  EXPECT_TRUE(json["covariance"][0][1].is_null());
}

TEST(DwellJson, BytesThatAreNotUtf8DoNotThrow) {
  Rig rig = test::sample_rig();
  rig.channels[0].name = "y\xff";
  EXPECT_TRUE(Json::accept(to_json(test::sample_dwell(), rig, {})));
}

TEST(DwellJson, ReadsBackWhatItWrote) {
  const std::string text = to_json(test::sample_dwell(), test::sample_rig(), test::sample_run());
  const auto back = parse_dwell(text);
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ(back->channels[3].name, "reaction");
  EXPECT_EQ(back->run.version, "0.1.0");
  EXPECT_EQ(back->dwell.index, 1);
  EXPECT_TRUE(std::isnan(back->dwell.settles_in_s));
  EXPECT_EQ(back->dwell.elements[0].budget[1].source, "delay of y0");
  EXPECT_EQ(back->dwell.phasors[2].reason, "stale: timeout");
}

// Everything but the phasors' last bit (polar to Cartesian and back) survives exactly.
RC_GTEST_PROP(DwellJson, RoundTripsEveryNumber, ()) {
  const auto any = [] {
    const double value = *rc::gen::arbitrary<double>();
    return std::isfinite(value) ? std::ldexp(value, *rc::gen::inRange(-900, 900)) : kNaN;
  };
  Rig rig = test::sample_rig();
  rig.motion = *rc::gen::element(Motion::translation, Motion::rotation);
  Dwell dwell = test::sample_dwell();
  dwell.index = *rc::gen::inRange(1, 1'000'000);
  dwell.state = *rc::gen::element(State::measuring, State::complete);
  dwell.ended_by = dwell.state == State::complete ? *rc::gen::element(EndedBy::end, EndedBy::data_lost) : EndedBy::none;
  dwell.settled_s = *rc::gen::map(rc::gen::inRange(0, 1'000'000), [](int i) { return i / 7.0; });
  dwell.t_ref_s = any();
  dwell.frequency_hz = {any(), any()};
  dwell.elements[0].stiffness = {any(), any(), any(), any(), *rc::gen::arbitrary<bool>()};
  dwell.elements[0].loss_factor = {any(), any()};
  for (double& entry : dwell.covariance) entry = any();
  dwell.phasors[0].Y = std::polar(std::fabs(0.1 * *rc::gen::inRange(1, 1000)), 0.003 * *rc::gen::inRange(-1000, 1000));
  const std::string text = to_json(dwell, rig, test::sample_run());
  const auto back = parse_dwell(text);
  RC_ASSERT(back.has_value());
  RC_ASSERT(std::abs(back->dwell.phasors[0].Y - dwell.phasors[0].Y) <= 1e-14 * std::abs(dwell.phasors[0].Y));
  DwellView again = *back;
  again.dwell.phasors[0].Y = dwell.phasors[0].Y;
  again.dwell.phasors[1].Y = dwell.phasors[1].Y;
  again.dwell.phasors[3].Y = dwell.phasors[3].Y;
  RC_ASSERT(to_json(again) == text);
}

TEST(DwellJson, NamesTheFieldThatIsNotAsExpected) {
  const auto mistake_of = [](const char* pointer, const Json& value) {
    Json json = sample_json();
    json[Json::json_pointer(pointer)] = value;
    const auto parsed = parse_dwell(dump(json));
    return parsed ? std::string() : parsed.error();
  };
  EXPECT_EQ(mistake_of("/state", "dancing"), "dwell object: state: expected one of the words of the interface");
  EXPECT_EQ(mistake_of("/settled_s", "soon"), "dwell object: settled_s: expected a number or null");
  EXPECT_EQ(mistake_of("/phasors", 3), "dwell object: phasors: expected an array");
  EXPECT_EQ(mistake_of("/phasors/0", 3), "dwell object: channel: expected to stand in an object");
  EXPECT_EQ(mistake_of("/elements/0/k", -1), "dwell object: k: expected an integer from 0 to 1e9");
  EXPECT_EQ(mistake_of("/covariance", Json::array({1})), "dwell object: covariance: expected an array of arrays");
  EXPECT_EQ(mistake_of("/some_later_extension", 3), "");
}

TEST(DwellJson, EscapesWhatATerminalMayObey) {
  const std::string controls = "\x7f|\u0080|\u009b|\u009f|\u061c|\u200e|\u202a|\u202e|\u2028|\u2029|\u2066|\u2069";
  EXPECT_EQ(dump(Json(controls)),
            R"("\u007f|\u0080|\u009b|\u009f|\u061c|\u200e|\u202a|\u202e|\u2028|\u2029|\u2066|\u2069")");
  EXPECT_EQ(Json::parse(dump(Json(controls))), Json(controls));
  const std::string harmless = "° \u00a0 µ · — € 😀 \u202f";
  EXPECT_EQ(dump(Json(harmless)), "\"" + harmless + "\"");
  EXPECT_EQ(dump(Json{{"a", "\u009b"}}, 2), "{\n  \"a\": \"\\u009b\"\n}");
}

constexpr char kFiller = 'x';

RC_GTEST_PROP(DwellJson, SurvivesAnyDamageToItsText, ()) {
  std::string text = to_json(test::sample_dwell(), test::sample_rig(), test::sample_run());
  const int cuts = *rc::gen::inRange(1, 6);
  for (int i = 0; i < cuts; ++i) {
    const std::size_t at = *rc::gen::inRange<std::size_t>(0, text.size());
    if (*rc::gen::arbitrary<bool>()) {
      text.erase(at, *rc::gen::inRange<std::size_t>(1, 40));
    } else {
      text[at] = *rc::gen::arbitrary<char>();
    }
    if (text.empty()) text.push_back(kFiller);
  }
  const auto parsed = parse_dwell(text);
  RC_ASSERT(parsed.has_value() || !parsed.error().empty());
}

}  // namespace
}  // namespace dwell
