// What Prometheus is told, and that its own parser reads it. Each number that is withheld is absent.
#include "daemon/serve/metrics.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "daemon/serve/api.hpp"
#include "tests/daemon/measured_service.hpp"

namespace dwell {
namespace {

struct Metrics : testing::Test, test::MeasuredService {
  // The lines of this family's samples.
  [[nodiscard]] std::string of(const std::string& name, const std::string& trouble = {}) const {
    const std::string text = metrics_text(view(trouble));
    std::string found;
    std::size_t begin = 0;
    for (std::size_t end = text.find('\n'); end != std::string::npos; begin = end + 1, end = text.find('\n', begin)) {
      const std::string line = text.substr(begin, end - begin);
      if (line.compare(0, name.size(), name) == 0 && (line[name.size()] == '{' || line[name.size()] == ' '))
        found += line + "\n";
    }
    return found;
  }
};

TEST_F(Metrics, AMeasuredElementHasItsCoefficientsAndTheirIntervals) {
  EXPECT_EQ(of("dwell_stiffness_newtons_per_meter"),
            "dwell_stiffness_newtons_per_meter{element=\"1\"} 24010\n"
            "dwell_stiffness_newtons_per_meter{element=\"3\"} 1234567\n")
      << "element 2 is not identifiable: absent";
  EXPECT_EQ(of("dwell_damping_u95_newton_seconds_per_meter"),
            "dwell_damping_u95_newton_seconds_per_meter{element=\"1\"} 0.79\n"
            "dwell_damping_u95_newton_seconds_per_meter{element=\"3\"} 0.79\n");
  EXPECT_NE(of("dwell_element_standing").find("{element=\"2\",standing=\"not identifiable\"} 1\n"), std::string::npos);
  EXPECT_NE(of("dwell_element_standing").find("{element=\"1\",standing=\"valid\"} 1\n"), std::string::npos);
}

TEST_F(Metrics, ARotatingRigHasItsOwnUnits) {
  rig.motion = Motion::rotation;
  EXPECT_EQ(of("dwell_stiffness_newtons_per_meter"), "");
  EXPECT_NE(of("dwell_stiffness_newton_meters_per_radian"), "");
}

TEST_F(Metrics, WhatTheIntervalsDoNotCoverIsNamed) {
  for (Channel& channel : rig.channels) {
    channel.scale_u = 1e-3;
    channel.delay_u_s = 1e-6;
  }
  rig.mass_u.assign(rig.masses.size(), 0.1);
  EXPECT_EQ(of("dwell_unstated_info"), "");
  rig.mass_u.clear();
  rig.channels[0].scale_u = 0.0;
  EXPECT_EQ(of("dwell_unstated_info"),
            "dwell_unstated_info{what=\"masses 1 and 2\"} 1\ndwell_unstated_info{what=\"scale of " +
                rig.channels[0].name + "\"} 1\n");
}

TEST_F(Metrics, ADoubtIsToldBesideTheNumbersItNames) {
  snapshot.dwell.doubts = {{{3}, "its c is negative"}};
  EXPECT_NE(of("dwell_element_standing").find("{element=\"3\",standing=\"doubtful\"} 1\n"), std::string::npos);
  EXPECT_NE(of("dwell_element_standing").find("{element=\"1\",standing=\"valid\"} 1\n"), std::string::npos);
  snapshot.dwell.doubts = {{{}, "the drive wanders"}};
  EXPECT_NE(of("dwell_element_standing").find("{element=\"1\",standing=\"doubtful\"} 1\n"), std::string::npos);
}

TEST_F(Metrics, NoNumberIsToldThatIsNotMeasuredNow) {
  snapshot.dwell.state = State::complete;
  EXPECT_EQ(of("dwell_stiffness_newtons_per_meter"), "");
  EXPECT_EQ(of("dwell_frequency_hertz"), "");
  EXPECT_NE(of("dwell_element_standing").find("{element=\"1\",standing=\"not settled\"} 1\n"), std::string::npos);
}

TEST_F(Metrics, NoNumberIsToldThatTheEstimationNoLongerRenews) {
  now_ns = snapshot.t_ns + 2'400'000'000;
  EXPECT_NE(of("dwell_stiffness_newtons_per_meter"), "");
  now_ns = snapshot.t_ns + 2'600'000'000;
  EXPECT_EQ(of("dwell_stiffness_newtons_per_meter"), "");
  EXPECT_EQ(of("dwell_state"), "");
  EXPECT_NE(of("dwell_element_standing").find("{element=\"1\",standing=\"stale\"} 1\n"), std::string::npos);
  EXPECT_EQ(of("dwell_estimate_age_seconds"), "dwell_estimate_age_seconds 2.6\n");
  now_ns = snapshot.t_ns + 2'400'000'000;
  EXPECT_EQ(of("dwell_stiffness_newtons_per_meter", "thread estimate has not turned"), "");
}

TEST_F(Metrics, OfAChannelThatDoesNotDeliverNeitherRateNorJitterIsTold) {
  for (ChannelView& channel : snapshot.channels) {
    channel.rate_hz = 200.0;
    channel.clock.jitter_s = 1e-4;
  }
  const std::string_view y0 = "{channel=\"y0\"}";
  for (const char* name : {"dwell_channel_rate_hertz", "dwell_channel_jitter_seconds"}) {
    snapshot.channels[0].fault = Fault::none;
    EXPECT_NE(of(name).find(y0), std::string::npos) << name;
    snapshot.channels[0].fault = Fault::timeout;
    EXPECT_EQ(of(name).find(y0), std::string::npos) << name;
  }
}

TEST_F(Metrics, NoStateIsToldThatTheEstimationNoLongerRenews) {
  chain_of(2);
  verify(Verdict::adequate);
  for (ChannelView& channel : snapshot.channels) channel.clock.jitter_s = 1e-4;
  const std::vector<std::string> states{"dwell_model_verdict",
                                        "dwell_model_contradicted",
                                        "dwell_model_error_ratio",
                                        "dwell_model_error_uncertainty_ratio",
                                        "dwell_channel_up",
                                        "dwell_channel_status",
                                        "dwell_channel_rate_hertz",
                                        "dwell_channel_jitter_seconds",
                                        "dwell_channel_queued_samples",
                                        "dwell_device_up"};
  for (const std::string& name : states) EXPECT_NE(of(name), "") << name;
  EXPECT_EQ(of("dwell_ready"), "dwell_ready 1\n");
  now_ns = snapshot.t_ns + 2'600'000'000;
  for (const std::string& name : states) EXPECT_EQ(of(name), "") << name;
  EXPECT_EQ(of("dwell_ready"), "dwell_ready 0\n");
  EXPECT_NE(of("dwell_channel_reading_age_seconds").find("{channel=\"y0\"} 2.7\n"), std::string::npos)
      << "an age is of now";
  EXPECT_NE(of("dwell_channel_received_samples_total"), "") << "a count stays what it was";
}

// Neighbours were told of coefficients, and not that one violates its limit.
TEST_F(Metrics, EachLimitHasItsVerdict) {
  EXPECT_EQ(of("dwell_limit_verdict"), "");
  rig.limits = {{1, Bounds{20e3, 21e3}, Bounds{0.0, 100.0}}};
  EXPECT_EQ(of("dwell_limit_verdict"),
            "dwell_limit_verdict{element=\"1\",coefficient=\"stiffness\",verdict=\"none\"} 0\n"
            "dwell_limit_verdict{element=\"1\",coefficient=\"stiffness\",verdict=\"kept\"} 0\n"
            "dwell_limit_verdict{element=\"1\",coefficient=\"stiffness\",verdict=\"undecided\"} 0\n"
            "dwell_limit_verdict{element=\"1\",coefficient=\"stiffness\",verdict=\"violated\"} 1\n"
            "dwell_limit_verdict{element=\"1\",coefficient=\"damping\",verdict=\"none\"} 0\n"
            "dwell_limit_verdict{element=\"1\",coefficient=\"damping\",verdict=\"kept\"} 1\n"
            "dwell_limit_verdict{element=\"1\",coefficient=\"damping\",verdict=\"undecided\"} 0\n"
            "dwell_limit_verdict{element=\"1\",coefficient=\"damping\",verdict=\"violated\"} 0\n");
  snapshot.dwell.state = State::complete;
  EXPECT_NE(of("dwell_limit_verdict").find("verdict=\"none\"} 1\n"), std::string::npos) << "none is measured now";
  now_ns += 3'000'000'000;
  EXPECT_EQ(of("dwell_limit_verdict"), "") << "stale";
}

TEST_F(Metrics, ACalibrationHasTheEndOfTheDayOnWhichItIsDue) {
  EXPECT_EQ(of("dwell_channel_calibration_due_timestamp_seconds"), "");
  rig.channels[0].calibration.id = "K-2231";
  EXPECT_EQ(of("dwell_channel_calibration_due_timestamp_seconds"), "");
  rig.channels[0].calibration.due = "2027-03-31";
  EXPECT_EQ(of("dwell_channel_calibration_due_timestamp_seconds"),
            "dwell_channel_calibration_due_timestamp_seconds{channel=\"y0\"} 1806537600\n");
}

TEST_F(Metrics, AStateIsOneOfItsNames) {
  EXPECT_EQ(of("dwell_state"),
            "dwell_state{state=\"idle\"} 0\ndwell_state{state=\"settling\"} 0\ndwell_state{state=\"measuring\"} 1\n"
            "dwell_state{state=\"complete\"} 0\ndwell_state{state=\"fault\"} 0\n");
  verify(Verdict::not_adequate);
  EXPECT_NE(of("dwell_model_verdict").find("{verdict=\"not adequate\"} 1\n"), std::string::npos);
  EXPECT_EQ(of("dwell_model_consistent"), "dwell_model_consistent 1\n");
  EXPECT_EQ(of("dwell_model_contradicted"), "dwell_model_contradicted 0\n");
  auto models = std::make_shared<VerifiedModels>(*snapshot.models);
  models->front().model.objection = "any motion: the chain does not explain y1";
  models->front().model.consistent.reset();
  snapshot.models = models;
  EXPECT_EQ(of("dwell_model_consistent"), "");
  EXPECT_EQ(of("dwell_model_contradicted"), "dwell_model_contradicted 1\n");
}

TEST_F(Metrics, AChannelsSamplesAddUp) {
  EXPECT_NE(of("dwell_channel_received_samples_total").find("{channel=\"y0\"} 10\n"), std::string::npos);
  EXPECT_NE(of("dwell_channel_dropped_samples_total").find("{channel=\"y0\",reason=\"refused\"} 1\n"),
            std::string::npos);
  EXPECT_NE(of("dwell_channel_status").find("{channel=\"y2\",status=\"timeout\"} 1\n"), std::string::npos);
}

TEST_F(Metrics, AlarmsAreCountedByTheirState) {
  EXPECT_NE(of("dwell_alarms").find("{state=\"unacknowledged\"} 0\n"), std::string::npos);
  raise_alarms();
  EXPECT_EQ(of("dwell_alarms"),
            "dwell_alarms{state=\"unacknowledged\"} 1\ndwell_alarms{state=\"acknowledged\"} 1\n"
            "dwell_alarms{state=\"returned-unacknowledged\"} 1\n");
  EXPECT_EQ(of("dwell_http_wrong_tokens_total"), "dwell_http_wrong_tokens_total 3\n");
}

TEST_F(Metrics, AreServedAsPrometheusAsksForThem) {
  const HttpReply reply = http_answer(view(), "/metrics", "");
  EXPECT_EQ(reply.status, 200);
  EXPECT_EQ(reply.content_type, "text/plain; version=0.0.4; charset=utf-8");
  EXPECT_EQ(reply.body, metrics_text(view()));
}

// Everything that can be served, of a translational and of a rotational rig, read by Prometheus' own Python client; the
// manual names all of it, and the dashboard asks for nothing else.
TEST_F(Metrics, AreReadByPrometheusAndSufficeForTheDashboard) {
  char name[] = "/tmp/dwell-metrics-XXXXXX";
  ASSERT_NE(mkdtemp(name), nullptr);
  const std::string folder = name;
  rig.name = "bench \"2\\ \xff\n";
  gpio[0].configured = gpio[0].works = true;
  gpio[0].level = true;
  recorder.emplace().recording = true;
  modbus.emplace();
  verify(Verdict::adequate);
  rig.limits = {{1, Bounds{20e3, 21e3}, std::nullopt}};
  rig.channels[0].calibration.due = "2027-03-31";
  for (ChannelView& channel : snapshot.channels) channel.clock.jitter_s = 1e-4;
  std::ofstream(folder + "/translation") << metrics_text(view());
  rig.motion = Motion::rotation;
  snapshot.dwell = test::settling_dwell();
  std::ofstream(folder + "/settling") << metrics_text(view());
  snapshot.dwell = test::sample_dwell();
  std::ofstream(folder + "/rotation") << metrics_text(view());
  const std::string command = std::string(DWELL_PYTHON) + " " + DWELL_SOURCE + "/tests/daemon/read_metrics.py " +
                              DWELL_SOURCE + "/config/grafana/dwell.json " + DWELL_SOURCE + "/docs/man/dwelld.8 " +
                              folder + "/translation " + folder + "/settling " + folder + "/rotation";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace dwell
