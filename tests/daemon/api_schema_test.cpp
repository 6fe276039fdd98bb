// Every answer is what docs/api.schema.json says, and every member of it is documented there.
#include "tests/api_schema.hpp"

#include <gtest/gtest.h>

#include "daemon/alarms/alarm_list.hpp"
#include "daemon/outlets/dwell_stream.hpp"
#include "daemon/serve/api.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell {
namespace {

using Json = nlohmann::json;

record::RecorderState recording_a_run() {
  record::RecorderState state;
  state.recording = true;
  state.run.run = 17;
  state.run.file = "bench-17-20261123T031217Z.dwell";
  state.run.begun_by = "drive";
  state.run.begun_utc = "2026-11-23T03:12:17.250000Z";
  state.run.state = "recording";
  state.run.bytes = 4711;
  state.alarms = {{"anchor", "heads are not anchored: command send: exit status 1"}};
  return state;
}

// A service that has everything to tell: channels in every condition, lines, faults, finished dwells.
struct ApiSchemaTest : testing::Test {
  ApiSchemaTest() {
    rig = test::sample_rig();
    rig.devices = {{"amplifier", 0.0, 0.0}};
    for (Channel& channel : rig.channels) channel.device = 0;
    snapshot.sequence = 1;
    snapshot.t_ns = 1'900'000'000;  // 0.1 s ago
    snapshot.channels.resize(rig.channels.size());
    snapshot.channels[0].value = 1.25;
    snapshot.channels[0].heard_ns = 1'900'000'000;
    snapshot.channels[0].fault = Fault::none;
    snapshot.channels[0].condition = Condition::ok;
    snapshot.channels[0].clock = {Clock::device, 199.98, 1e-4, -100.0, 3};
    snapshot.channels[0].tally = {10, 5, 1, 1, 0, 1, 2};
    snapshot.channels[1].fault = Fault::none;
    snapshot.channels[1].condition = Condition::stuck;
    snapshot.channels[1].condition_reason = "the same reading for 12.0 s";
    snapshot.channels[2].fault = Fault::timeout;
    snapshot.channels[2].reason = "no answer within 0.1 s";
    snapshot.devices.resize(1);
    snapshot.devices[0].name = "amplifier";
    snapshot.devices[0].driver = "modbus";
    snapshot.devices[0].faults[2] = 7;
    lines[0] = {true, true, "", true, 5, 1, 0};
    lines[3] = {true, false, "there is no /dev/gpiochip0", std::nullopt, 0, 0, 0};
    snapshot.dwell = test::sample_dwell();
    snapshot.dwell.doubts = {{{1, 3}, "the poles contradict the chain"}};
    snapshot.dwell.unstated = {"scale of y0"};
    auto list = std::make_shared<FinishedDwells>();
    Dwell finished = test::sample_dwell();
    finished.state = State::complete;
    finished.ended_by = EndedBy::drive_changed;
    list->push_back(std::make_shared<const Dwell>(finished));
    snapshot.dwell.index = 2;
    snapshot.finished = list;
    auto transient = std::make_shared<TransientEstimate>();
    transient->estimate = test::sample_motion();
    transient->from_s = 39.25;
    transient->until_s = 43.2;
    transient->given = 2310;
    snapshot.transient = transient;
    snapshot.transient_agreement = {1, CoefficientKind::stiffness, 0.3, false, 0.4};
    events.push(Level::info, "state idle -> settling", 1'700'000'000'000'000'000);
    auto verified = std::make_shared<VerifiedDwell>();
    verified->dwell = snapshot.dwell;
    verified->verification = test::sample_verification();
    snapshot.verified = verified;
    rig.limits = {{1, Bounds{23e3, 25e3}, Bounds{10.0, 20.0}}, {2, Bounds{1.0, 2.0}, std::nullopt}};
    rig.channels[0].calibration.id = "K-2231";
    rig.channels[0].calibration.due = "2027-03-31";
    rig.channels[1].calibration.id = "K-2232";
    alarms.follow({{"channel:y2", "channel y2: timeout"}}, {}, {0, 0});
    alarms.follow({{"channel:y2", "channel y2: timeout"}, {"log", ""}}, {}, {AlarmList::kLasts_ns, 1});
  }
  [[nodiscard]] ServiceView view() const {
    ServiceView now{rig, run, snapshot};
    now.now_ns = 2'000'000'000;
    now.now_utc_ns = 1'700'000'000'000'000'000;
    now.uptime_s = 3.5;
    now.threads = {{"estimate", 1'990'000'000, 1'000'000'000}};
    now.gpio = lines;
    now.recording.state = recording;
    now.recording.runs = runs;
    now.events = &events;
    now.alarms = &alarms;
    now.health = judge_health(rig, snapshot, now.now_ns, now.gpio, now.log, "");
    return now;
  }
  [[nodiscard]] std::string get(const std::string& path) const { return http_answer(view(), path, "").body; }
  [[nodiscard]] std::string control(const std::string& line) const {
    return control_answer(view(), line, [](const OperatorRequest&) { return tl::expected<void, std::string>(); });
  }
  void expect_all() const {
    EXPECT_EQ(schema.faults_of_text("dwell", get("/api/v1/dwell")), "");
    EXPECT_EQ(schema.faults_of_text("dwells", get("/api/v1/dwells")), "");
    EXPECT_EQ(schema.faults_of_text("brief_dwells", http_answer(view(), "/api/v1/dwells", "brief=1").body), "");
    EXPECT_EQ(schema.faults_of_text("events", get("/api/v1/events")), "");
    EXPECT_EQ(schema.faults_of_text("alarms", get("/api/v1/alarms")), "");
    EXPECT_EQ(schema.faults_of_text("channels", get("/api/v1/channels")), "");
    EXPECT_EQ(schema.faults_of_text("verification", get("/api/v1/verification")), "");
    EXPECT_EQ(schema.faults_of_text("runs", get("/api/v1/runs")), "");
    EXPECT_EQ(schema.faults_of_text("health", get("/api/v1/health")), "");
    EXPECT_EQ(schema.faults_of_text("status", control(R"({"verb":"status"})")), "");
    EXPECT_EQ(schema.faults_of_text("check", control(R"({"verb":"check"})")), "");
  }

  test::ApiSchema schema;
  Rig rig;
  RunInfo run = test::sample_run();
  Snapshot snapshot;
  gpio::Status lines{};
  NewestLines events;
  AlarmList alarms;
  std::optional<record::RecorderState> recording = recording_a_run();
  std::shared_ptr<const record::ListedRuns> runs =
      std::make_shared<const record::ListedRuns>(record::ListedRuns{recording_a_run().run});
};

TEST_F(ApiSchemaTest, DocumentsEveryMemberAndTheUnitOfEveryNumber) { EXPECT_EQ(schema.undocumented(), ""); }

TEST_F(ApiSchemaTest, IsMetByEveryAnswer) {
  expect_all();
  snapshot.t_ns = -8'000'000'000;  // stale
  expect_all();
  EXPECT_EQ(schema.faults_of_text("dwell", get("/api/v1/dwells/1")), "");
  EXPECT_EQ(schema.faults_of_text("error", get("/api/v1/nowhere")), "");
  EXPECT_EQ(schema.faults_of_text("error", get("/api/v1/dwells/99")), "");
  EXPECT_EQ(schema.faults_of_text("error", http_answer(view(), "/api/v1/dwells", "?").body), "");
  EXPECT_EQ(schema.faults_of_text("done", control(R"({"verb":"rearm"})")), "");
  EXPECT_EQ(schema.faults_of_text("control_error", control("x")), "");
}

TEST_F(ApiSchemaTest, IsMetWhereNothingIsKnownYet) {
  snapshot = Snapshot();
  snapshot.channels.resize(rig.channels.size());
  snapshot.devices.resize(1);
  run = {};
  lines = {};
  recording = record::RecorderState();
  runs = nullptr;
  expect_all();
  snapshot.dwell = test::settling_dwell();
  expect_all();
  auto none = std::make_shared<TransientEstimate>();
  none->estimate.reason = "too few readings: 30";
  snapshot.transient = none;
  expect_all();
}

TEST_F(ApiSchemaTest, IsMetByWhatALiveStreamIsTold) {
  DwellStream stream;
  EXPECT_EQ(schema.faults_of_text("dwell", stream.next(live_dwell(view()), 0).data), "");
  snapshot.dwell.end_s += 0.1;
  snapshot.dwell.frequency_hz.u *= 0.9;
  snapshot.dwell.phasors[0].u_amplitude *= 0.9;
  snapshot.dwell.elements[0].stiffness.value += 1.0;
  snapshot.dwell.elements[0].deformation.u *= 0.9;
  snapshot.dwell.elements[1].deformation.u *= 0.9;
  auto moved = std::make_shared<TransientEstimate>(*snapshot.transient);
  moved->estimate.elements[0].stiffness.value += 1.0;
  moved->estimate.end_s += 1.0;
  moved->until_s += 1.0;
  snapshot.transient = moved;
  snapshot.transient_agreement = {2, CoefficientKind::damping, 1.2, true, 0.5};
  auto verified = std::make_shared<VerifiedDwell>(*snapshot.verified);
  verified->verification.seen = 0.013;
  snapshot.verified = verified;
  const DwellStream::Event event = stream.next(live_dwell(view()), 1);
  EXPECT_STREQ(event.name, "change");
  EXPECT_EQ(schema.faults_of_text("change", event.data), "");
}

TEST_F(ApiSchemaTest, IsNotMetByAMemberThatIsNotDocumentedIsMissingOrOfAnotherType) {
  const Json dwell = Json::parse(get("/api/v1/dwell"));
  ASSERT_EQ(schema.faults("dwell", dwell), "");
  Json more = dwell;
  more["elements"][0]["stiffness"]["news"] = 1;
  EXPECT_NE(schema.faults("dwell", more).find("dwell.elements[0].stiffness: \"news\" is not documented"),
            std::string::npos)
      << schema.faults("dwell", more);
  Json less = dwell;
  less["phasors"][0].erase("unit");
  EXPECT_NE(schema.faults("dwell", less).find("dwell.phasors[0]: has no \"unit\""), std::string::npos);
  Json other = dwell;
  other["state"] = "resting";
  other["end_s"] = "late";
  EXPECT_NE(schema.faults("dwell", other).find("dwell.state: expected one of"), std::string::npos);
  EXPECT_NE(schema.faults("dwell", other).find("dwell.end_s: expected"), std::string::npos);
}

}  // namespace
}  // namespace dwell
