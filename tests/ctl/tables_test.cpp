#include "daemon/ctl/tables.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "daemon/ctl/truth.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell::ctl {
namespace {

using Json = nlohmann::ordered_json;

TEST(Tables, ChannelsShowWhatTheServiceKnowsAndDashesForWhatItDoesNot) {
  const Json list = Json::parse(R"([
    {"name":"y0","value":4.70639,"unit":"mm","status":"ok","reason":null,"age_s":0.0021,"rate_hz":499.9,
     "clock":"device","clock_rate_hz":500.0213,"jitter_s":0.00029,"drift_ppm":42.6,"lost":3,
     "received":123456,"used":123450,"dropped":4,"queued":2,"gaps":1},
    {"name":"θ","value":null,"unit":"um","status":"timeout","reason":"no answer within 0.1 s","age_s":12.5,
     "rate_hz":null,"clock":"host","clock_rate_hz":null,"jitter_s":null,"drift_ppm":null,"lost":0,"received":9,"used":9,"dropped":0,"queued":0,"gaps":0},
    {"name":7}, 3])");
  EXPECT_EQ(
      channels_table(list),
      R"(channel  status   value            age      rate  clock                jitter     drift  lost  received    used  dropped  queued  gaps
y0       ok       4.70639 mm   0.002 s  499.9 Hz  device 500.021 Hz  0.290 ms  42.6 ppm     3    123456  123450        4       2     1
θ        timeout        —     12.500 s         —  host                      —         —     0         9       9        0       0     0  no answer within 0.1 s
                        —            —         —  —                         —         —     —         —       —        —       —     —
                        —            —         —  —                         —         —     —         —       —        —       —     —
)");
}

TEST(Tables, ChannelsShowTheirCalibrationsWhereOneIsStated) {
  const Json list = Json::parse(R"([
    {"name":"y0","status":"ok","calibration":{"id":"K-2231","due":"2027-03-31","overdue":false}},
    {"name":"y1","status":"ok","calibration":{"id":"K-7","due":"2025-03-31","overdue":true}},
    {"name":"y2","status":"ok","calibration":null}])");
  const std::string text = channels_table(list);
  EXPECT_NE(text.find("calibration"), std::string::npos) << text;
  EXPECT_NE(text.find("K-2231, due 2027-03-31\n"), std::string::npos) << text;
  EXPECT_NE(text.find("K-7, due 2025-03-31: overdue\n"), std::string::npos) << text;
}

TEST(Tables, DwellsHaveOneLinePerElement) {
  Dwell first = test::sample_dwell();
  first.state = State::complete;
  first.ended_by = EndedBy::drive_changed;
  Dwell second = test::settling_dwell();
  second.state = State::complete;
  second.ended_by = EndedBy::end;
  const Rig rig = test::sample_rig();
  EXPECT_EQ(dwells_table({make_view(first, rig, {}), make_view(second, rig, {})}),
            R"(dwell  ended by       frequency                 data  element  stiffness               damping
    1  drive changed  4.000300 ± 0.000039 Hz  24.6 s        1   24.010 ±   0.027 kN/m  60.20 ± 0.79 N·s/m
                                                            2        —                     —                     the deformation is less than three times its uncertainty
                                                            3  1.23457 ± 0.00020 MN/m    210 ±  790 mN·s/m n.s.
    2  end               4.000            Hz       —                                                             not settled: 2.1 % of the transient of reaction is left, 0.5 % allowed
± is the half width of the 95 % interval, if the rig is as its file says; n.s.: not significant, smaller than its standard uncertainty
)");
}

TEST(Tables, DwellsSayFirstWhichNumbersMustNotBeReliedOnAndBelowWhatTheyLeaveOut) {
  Dwell dwell = test::sample_dwell();
  dwell.doubts = {{{1}, "y1 and y2 look swapped"}};
  dwell.unstated = {"masses", "scale of y1"};
  Dwell settling = test::settling_dwell();
  settling.unstated = {"never measured"};
  const Rig rig = test::sample_rig();
  const std::string text = dwells_table({make_view(dwell, rig, {}), make_view(settling, rig, {})});
  EXPECT_EQ(text.substr(0, text.find('\n')), "dwell 1: do not rely on element 1: y1 and y2 look swapped");
  EXPECT_NE(text.find("24.010 ±   0.027 kN/m ?  60.20 ± 0.79 N·s/m ?"), std::string::npos) << text;
  EXPECT_NE(text.find("; ?: do not rely on it, the reason stands with the dwell\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\n± covers only noise, clock and what the rig file states; not stated: masses, scale of y1\n"),
            std::string::npos)
      << text;
}

TEST(Tables, DwellsShowTheVerdictsOnTheirLimitsAndModels) {
  Rig rig = test::sample_rig();
  rig.limits = {{1, Bounds{20e3, 21e3}, Bounds{0.0, 100.0}}};
  DwellView view = make_view(test::sample_dwell(), rig, {});
  view.model = ModelVerdict{Verdict::adequate, true, 0.05, 0.012, 0.004};
  const std::string text = dwells_table({view});
  EXPECT_NE(text.find("24.010 ±   0.027 kN/m limit violated  60.20 ± 0.79 N·s/m limit kept"), std::string::npos)
      << text;
  EXPECT_NE(text.find("  model"), std::string::npos) << text;
  EXPECT_NE(text.find("  adequate\n"), std::string::npos) << text;
}

// The cell said "adequate" alone.
TEST(Tables, DwellsShowWhatIsHeldAgainstTheirModels) {
  DwellView view = make_view(test::sample_dwell(), test::sample_rig(), {});
  view.model = ModelVerdict{Verdict::adequate, false, 0.05, 0.012, 0.004, "any motion: the chain does not explain y1"};
  const std::string text = dwells_table({view});
  EXPECT_NE(text.find("  adequate, not consistent, objection\n"), std::string::npos) << text;
  EXPECT_EQ(text.substr(0, text.find('\n')), "dwell 1: any motion: the chain does not explain y1");
}

// A stuck or clipped reading, and garbage, in a table that stays one.
TEST(Tables, ChannelsShowTheConditionOfTheirReadingsAndLineUpForGarbage) {
  const Json list = Json::parse(R"([
    {"name":"y0","value":4.70639,"unit":"mm","status":"ok","reason":null,"age_s":0.0021,"rate_hz":499.9},
    {"name":"y1","value":1.0e31,"unit":"mm","status":"overrange","reason":"1e+31 mm, beyond -10 ... 10 mm","age_s":3e17,"rate_hz":1e300},
    {"name":"y2","value":-1.23456789e-300,"unit":"mm","status":"stuck","reason":"the same reading for 12.0 s","age_s":0.002,"rate_hz":499.9},
    {"name":"y3","value":-123456.789,"unit":"mm","status":"clipped","reason":"12 % of the readings at 9.998 mm","age_s":0.002,"rate_hz":0.0001}])");
  EXPECT_EQ(
      channels_table(list),
      R"(channel  status     value                 age      rate  clock  jitter  drift  lost  received  used  dropped  queued  gaps
y0       ok               4.70639 mm  0.002 s  499.9 Hz  —           —      —     —         —     —        —       —     —
y1       overrange          1e+31 mm        —         —  —           —      —     —         —     —        —       —     —  1e+31 mm, beyond -10 ... 10 mm
y2       stuck      -1.23457e-300 mm  0.002 s  499.9 Hz  —           —      —     —         —     —        —       —     —  the same reading for 12.0 s
y3       clipped          -123457 mm  0.002 s    0.0 Hz  —           —      —     —         —     —        —       —     —  12 % of the readings at 9.998 mm
)");
}

TEST(Tables, ACheckSaysWhoAnswers) {
  const Json list = Json::parse(R"([
    {"name":"y0","device":"amplifier","value":4.7,"unit":"mm","rate_hz":499.94,"latency_s":0.0009,"status":"ok","reason":null},
    {"name":"reaction","device":"bus","value":null,"unit":"N","rate_hz":null,"latency_s":null,"status":"timeout","reason":"no answer"}])");
  const std::vector<Probed> channels = probed_from_json(list);
  ASSERT_EQ(channels.size(), 2U);
  EXPECT_TRUE(channels[0].answers());
  EXPECT_FALSE(channels[1].answers());
  for (const char* status : {"overrange", "stuck", "held", "clipped", "gated"}) {
    Probed probed;
    probed.status = status;
    EXPECT_TRUE(probed.answers()) << status;
    EXPECT_EQ(probed.gated(), std::string(status) == "gated");
  }
  EXPECT_EQ(check_table(channels),
            R"(channel   status   device     value       rate  latency
y0        ok       amplifier  4.7 mm  499.9 Hz  0.90 ms
reaction  timeout  bus          —            —        —  no answer
)");
  EXPECT_EQ(check_json(channels)["channels"][1]["value"], nullptr);
  EXPECT_EQ(check_json(channels)["channels"][1]["reason"], "no answer");
  EXPECT_EQ(check_json(channels)["channels"][0]["latency_s"], 0.0009);
}

TEST(Truth, IsReadFromAFileOrRefusedWithWhatWasExpected) {
  const test::TemporaryFolder folder;
  const auto truth = read_truth(folder.file("t", R"({"masses":[1],"stiffness":[24000,5],"damping":[60,1]})"));
  ASSERT_TRUE(truth);
  EXPECT_EQ(truth->stiffness, (std::vector<double>{24000, 5}));
  EXPECT_FALSE(read_truth(folder.path("none")));
  for (const char* wrong : {"", "[]", R"({"stiffness":[1]})", R"({"stiffness":[1],"damping":["x"]})",
                            R"({"stiffness":[1,2],"damping":[1]})"}) {
    EXPECT_FALSE(read_truth(folder.file("w", wrong))) << wrong;
  }
}

TEST(Truth, AgreesOnlyIfEveryCoefficientIsThereAndNearEnough) {
  Dwell dwell = test::sample_dwell();
  dwell.elements.erase(dwell.elements.begin() + 1);  // the one that is not identifiable
  std::string why;
  EXPECT_TRUE(agrees(dwell, {{24010.0 + 55.0, 1234567.0}, {60.2, 0.21 - 1.59}}, 4.0, why)) << why;
  EXPECT_FALSE(agrees(dwell, {{24010.0 + 57.0, 1234567.0}, {60.2, 0.21}}, 4.0, why));
  EXPECT_EQ(why, "element 1: the stiffness is off by more than 4 standard uncertainties");
  EXPECT_FALSE(agrees(dwell, {{24010.0, 1234567.0}, {60.2, 0.21 - 1.61}}, 4.0, why));
  EXPECT_EQ(why, "element 3: the damping is off by more than 4 standard uncertainties");
  EXPECT_FALSE(agrees(dwell, {{24010.0}, {60.2}}, 4.0, why));
  dwell.elements[0].damping.u = kNaN;
  EXPECT_FALSE(agrees(dwell, {{24010.0, 1234567.0}, {60.2, 0.21}}, 4.0, why)) << "no uncertainty is no agreement";
  EXPECT_FALSE(agrees(test::sample_dwell(), {{1, 2, 3}, {1, 2, 3}}, 1e9, why));
  EXPECT_EQ(why, "element 2 is not identifiable: the deformation is less than three times its uncertainty");
}

TEST(GpioText, TellsHowTheInterlockStandsAndWhatDoesNotWork) {
  EXPECT_EQ(gpio_text(Json::parse(R"({"status":"ok"})")), "");
  for (const char* quiet : {R"({"status":"ok","recorder":null})", R"({"recorder":{"alarms":[]}})"})
    EXPECT_EQ(recording_text(Json::parse(quiet)), "");
  EXPECT_EQ(recording_text(Json::parse(R"({"troubles":[{"name":"x","text":"y1 is silent"}],
                                           "recorder":{"alarms":["disk full"]}})")),
            "recording  disk full\n");
  EXPECT_EQ(gpio_text(Json::parse(R"({"gpio":{"interlock":{"works":true,"reason":null,"level":1}}})")),
            "interlock  closed\n");
  EXPECT_EQ(gpio_text(Json::parse(R"({"gpio":{"interlock":{"works":true,"reason":null,"level":0},
                                             "ready":{"works":false,"reason":"in\u001b use","level":null}}})")),
            "interlock  open: the shaker may not run\ngpio       ready does not work: in? use\n");
  for (const char* odd : {"1", "[]", R"({"gpio":3})", R"({"gpio":{"interlock":7}})"})
    EXPECT_EQ(gpio_text(Json::parse(odd)), "") << odd;
}

}  // namespace
}  // namespace dwell::ctl
