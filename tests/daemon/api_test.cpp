#include "daemon/serve/api.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>

namespace dwell {
namespace {

using Json = nlohmann::json;

struct ApiTest : testing::Test {
  ApiTest() {
    rig.name = "bench \xff 2";  // not UTF-8
    rig.devices = {{"amplifier", 0.0, 0.0}};
    Channel channel;
    channel.name = "y0";
    channel.device = 0;
    channel.unit = "mm";
    rig.channels = {channel};
    snapshot.sequence = 1;
    snapshot.t_ns = 1'900'000'000;  // 0.1 s ago
    snapshot.channels.resize(1);
    snapshot.channels[0].tally = {10, 5, 1, 1, 0, 1, 2};
    snapshot.channels[0].half_width_s = 1e-3;
    snapshot.devices.resize(1);
    snapshot.devices[0].name = "amplifier";
    snapshot.devices[0].driver = "modbus";
    snapshot.devices[0].faults[2] = 7;
    snapshot.dwell.phasors.resize(1);
  }
  // A dwell with one element, whose stiffness keeps its limit.
  void keep_a_limit(State state) {
    rig.limits = {{1, Bounds{23e3, 25e3}, std::nullopt}};
    snapshot.dwell.index = 1;
    snapshot.dwell.state = state;
    snapshot.dwell.settled_s = 3.0;
    ElementEstimate& element = snapshot.dwell.elements.emplace_back();
    element.k = 1;
    element.identifiable = true;
    element.stiffness = {24e3, 10.0, 1e3, 20.0, true};
  }
  [[nodiscard]] ServiceView view(const std::string& trouble = {}) const {
    ServiceView now{rig, run, snapshot};
    now.now_ns = 2'000'000'000;
    now.uptime_s = 3.5;
    now.threads = {{"estimate", 1'990'000'000, 1'000'000'000}};
    now.verification = verification;
    return judged(now, trouble);
  }
  [[nodiscard]] static ServiceView judged(ServiceView now, const std::string& trouble = {}) {
    now.health = judge_health(now.rig, now.snapshot, now.now_ns, now.gpio, now.log, trouble);
    return now;
  }
  [[nodiscard]] Json get(const char* path, const char* query = "") const {
    const HttpReply reply = http_answer(view(), path, query);
    EXPECT_EQ(reply.status, 200) << reply.body;
    return Json::parse(reply.body);
  }
  [[nodiscard]] Json control(const std::string& line) {
    return Json::parse(control_answer(view(), line, [this](const OperatorRequest& request) {
      asked.push_back(request);
      return refusal.empty() ? tl::expected<void, std::string>() : tl::unexpected(refusal);
    }));
  }
  void finish(int dwells) {
    auto list = std::make_shared<FinishedDwells>();
    for (int i = 1; i <= dwells; ++i) {
      Dwell dwell;
      dwell.index = i;
      dwell.state = State::complete;
      dwell.phasors.resize(1);
      list->push_back(std::make_shared<const Dwell>(dwell));
    }
    snapshot.finished = list;
  }

  Rig rig;
  RunInfo run{"abc", "0.1.0", ""};
  Snapshot snapshot;
  config::VerificationSettings verification;
  std::vector<OperatorRequest> asked;
  std::string refusal;  // of what an operator asks for; empty: it is done
};

TEST_F(ApiTest, AChannelHasTheFieldsOfTheInterface) {
  snapshot.channels[0].value = 1.25;
  snapshot.channels[0].fault = Fault::none;
  snapshot.channels[0].heard_ns = 1'900'000'000;
  const Json channel = get("/api/v1/channels")["channels"][0];
  for (const char* key :
       {"name", "value", "unit", "status", "age_s", "rate_hz", "received", "used", "dropped", "queued", "gaps", "lost"})
    EXPECT_TRUE(channel.contains(key)) << key;
  EXPECT_EQ(channel["clock"], "host");
  for (const char* key : {"clock_rate_hz", "jitter_s", "drift_ppm"})
    EXPECT_TRUE(channel[key].is_null()) << key << ": not known yet";
  snapshot.channels[0].rate_hz = 200.0;
  snapshot.channels[0].clock.jitter_s = 1e-4;
  for (const auto& [fault, told] : {std::pair(Fault::none, true), std::pair(Fault::timeout, false)}) {
    snapshot.channels[0].fault = fault;
    const Json now = get("/api/v1/channels")["channels"][0];
    for (const char* key : {"rate_hz", "jitter_s"}) EXPECT_EQ(now[key].is_number(), told) << key;
  }
  EXPECT_EQ(channel["status"], "ok");
  EXPECT_NEAR(channel["age_s"].get<double>(), 0.1, 1e-9);
  EXPECT_EQ(channel["received"].get<int>(),
            channel["used"].get<int>() + channel["dropped"].get<int>() + channel["queued"].get<int>());
}

TEST_F(ApiTest, AChannelTellsStatusAndReasonInOneLine) {
  ChannelView& channel = snapshot.channels[0];
  const auto text = [this] { return get("/api/v1/channels")["channels"][0]["text"]; };
  channel.fault = Fault::timeout;
  EXPECT_EQ(text(), "timeout");
  channel.reason = "no answer within 0.1 s";
  EXPECT_EQ(text(), "timeout: no answer within 0.1 s");
  channel.fault = Fault::none;
  channel.condition = Condition::stuck;
  channel.condition_reason = "stuck at one reading for 12.0 s";
  EXPECT_EQ(text(), "stuck at one reading for 12.0 s") << "the word does not stand there twice";
}

// "450 Hz" stood beside a reading that was 5.7 s old.
TEST_F(ApiTest, AChannelHasARateOnlyWhileItIsKnownToDeliver) {
  ChannelView& channel = snapshot.channels[0];
  channel.fault = Fault::none;
  channel.heard_ns = 1'900'000'000;
  channel.rate_hz = 450.0;
  const auto rates = [](const ServiceView& now) {
    const Json channels = Json::parse(http_answer(now, "/api/v1/channels", "").body);
    const Json check = Json::parse(control_answer(now, R"({"verb":"check"})", nullptr));
    return Json{channels["channels"][0]["rate_hz"], check["channels"][0]["rate_hz"]};
  };
  EXPECT_EQ(rates(view()), (Json{450.0, 450.0}));
  EXPECT_EQ(rates(view("thread estimate has not turned for 3.0 s")), (Json{nullptr, nullptr}));
  channel.fault = Fault::silent;
  EXPECT_EQ(rates(view()), (Json{nullptr, nullptr}));
  channel.fault = Fault::none;
  snapshot.t_ns = -1'000'000'000;  // 3 s ago
  EXPECT_EQ(rates(view()), (Json{nullptr, nullptr}));
}

// A channel that delivers the same reading for ever, or garbage, showed as "ok".
TEST_F(ApiTest, AChannelsStatusIsTheConditionOfItsReadings) {
  ChannelView& channel = snapshot.channels[0];
  channel.fault = Fault::none;
  channel.condition = Condition::stuck;
  channel.condition_reason = "the same reading for 12.0 s";
  EXPECT_EQ(get("/api/v1/channels")["channels"][0]["status"], "stuck");
  EXPECT_EQ(get("/api/v1/channels")["channels"][0]["reason"], "the same reading for 12.0 s");
  EXPECT_EQ(control(R"({"verb":"check"})")["channels"][0]["status"], "stuck");
  channel.fault = Fault::timeout;
  channel.reason = "no answer within 0.1 s";
  EXPECT_EQ(get("/api/v1/channels")["channels"][0]["status"], "timeout");
  EXPECT_EQ(get("/api/v1/channels")["channels"][0]["reason"], "no answer within 0.1 s");
}

TEST_F(ApiTest, WhatIsNotKnownIsNull) {
  snapshot.channels[0].rate_hz = std::numeric_limits<double>::infinity();
  const Json channel = get("/api/v1/channels")["channels"][0];
  EXPECT_TRUE(channel["value"].is_null());
  EXPECT_TRUE(channel["age_s"].is_null());
  EXPECT_TRUE(channel["rate_hz"].is_null());
  EXPECT_EQ(channel["status"], "silent");
  EXPECT_TRUE(get("/api/v1/dwell")["index"].is_null());
}

TEST_F(ApiTest, HealthTellsADegradedRigFromABrokenService) {
  EXPECT_EQ(get("/api/v1/health")["status"], "degraded");
  EXPECT_EQ(get("/api/v1/health")["stale"], Json::array({"y0"}));
  EXPECT_EQ(get("/api/v1/health")["devices"][0]["faults"]["timeout"], 7);
  snapshot.channels[0].fault = Fault::none;
  EXPECT_EQ(get("/api/v1/health")["status"], "ok");
  const HttpReply broken = http_answer(view("thread estimate has not turned for 3.0 s"), "/api/v1/health", "");
  EXPECT_EQ(broken.status, 503);
  EXPECT_EQ(Json::parse(broken.body)["status"], "fault");
}

TEST_F(ApiTest, FinishedDwellsComeInBoundedPortions) {
  finish(250);
  const Json newest = get("/api/v1/dwells");
  ASSERT_EQ(newest["dwells"].size(), kDwellsPerAnswer);
  EXPECT_EQ(newest["dwells"].front()["index"], 151);
  EXPECT_EQ(newest["dwells"].back()["index"], 250);
  EXPECT_EQ(newest["total"], 250);
  const Json first = get("/api/v1/dwells", "from=1");
  ASSERT_EQ(first["dwells"].size(), kDwellsPerAnswer);
  EXPECT_EQ(first["dwells"].back()["index"], 100);
  EXPECT_EQ(get("/api/v1/dwells", "from=251")["dwells"].size(), 0u);
  EXPECT_EQ(first["next"], 101);
  EXPECT_TRUE(newest["next"].is_null()) << "the newest is there";
  const Json some = get("/api/v1/dwells", "from=11&count=5");
  ASSERT_EQ(some["dwells"].size(), 5u);
  EXPECT_EQ(some["dwells"].front()["index"], 11);
  EXPECT_EQ(some["next"], 16);
  EXPECT_EQ(get("/api/v1/dwells", "count=2")["dwells"].front()["index"], 249);
  EXPECT_EQ(get("/api/v1/dwells", "count=100")["dwells"].size(), kDwellsPerAnswer);
  EXPECT_EQ(get("/api/v1/dwells", "from=0&count=1")["dwells"][0]["index"], 1);
  EXPECT_TRUE(get("/api/v1/dwells", "from=250")["next"].is_null());
  for (const char* wrong :
       {"from=", "from=x", "from=1&x=2", "to=3", "from=99999999999999999999", "count=0", "count=-1", "from=1&from=2",
        "count=1&count=1", "from", "count=1x", "brief=2", "brief", "from=-1", "count=101", "brief=1&brief=1"})
    EXPECT_EQ(http_answer(view(), "/api/v1/dwells", wrong).status, 400) << wrong;
  const auto why = [&](const char* path, const char* query) {
    const HttpReply reply = http_answer(view(), path, query);
    return std::to_string(reply.status) + " " + Json::parse(reply.body)["error"].get<std::string>();
  };
  EXPECT_EQ(why("/api/v1/dwells", "brief=1&from=-1"),
            "400 \"from=-1\" is not understood: expected from=INDEX (0 or more), count=1 to 100, brief=1, or several "
            "joined by &");
  EXPECT_EQ(why("/api/v1/events", "count=201"),
            "400 \"count=201\" is not understood: expected from=NUMBER (0 or more), count=1 to 200, or several joined "
            "by &");
  EXPECT_EQ(why("/api/v1/runs", "from=1&from=2"),
            "400 \"from=2\" is not understood: from is given twice; expected from=RUN (0 or more) or from=RUN:FILE, "
            "count=1 to 100, or several joined by &");
}

// A slip of the pen must not look like an answer to it.
TEST_F(ApiTest, AQueryIsRefusedWhereNoneIsExpected) {
  finish(3);
  for (const char* path : {"/api/v1/dwell", "/api/v1/dwells/2", "/api/v1/channels", "/metrics", "/api/v1/verification",
                           "/api/v1/alarms", "/api/v1/health"}) {
    EXPECT_NE(http_answer(view(), path, "").status, 400) << path;
    const HttpReply reply = http_answer(view(), path, "foo=1");
    EXPECT_EQ(reply.status, 400) << path;
    EXPECT_EQ(Json::parse(reply.body)["error"], "\"foo=1\" is not understood: expected no query here") << path;
  }
  EXPECT_EQ(http_answer(view(), "/nowhere", "foo=1").status, 404);
}

TEST_F(ApiTest, AnAnswerOfManyLargeDwellsStaysWithinItsBytesAndSaysHowToGoOn) {
  auto list = std::make_shared<FinishedDwells>();
  for (int i = 1; i <= 40; ++i) {
    Dwell dwell;
    dwell.index = i;
    dwell.state = State::complete;
    dwell.settled_s = 1.0;
    dwell.covariance.assign(3600, 196.0 / 7.0);  // of 30 elements
    dwell.elements.resize(30);
    for (ElementEstimate& element : dwell.elements) {
      element.identifiable = true;
      element.budget.assign(90, BudgetShare{"scale of y1", 1.0 / 7.0, 1.0 / 7.0, SourceKind::other, {}});
    }
    list->push_back(std::make_shared<const Dwell>(dwell));
  }
  snapshot.finished = list;
  int seen = 0;
  for (Json next = 1; !next.is_null();) {
    const HttpReply reply = http_answer(view(), "/api/v1/dwells", "from=" + std::to_string(next.get<int>()));
    EXPECT_LT(reply.body.size(), kBytesOfDwells + 10'000);
    const Json answer = Json::parse(reply.body);
    for (const Json& dwell : answer["dwells"]) EXPECT_EQ(dwell["index"], ++seen);
    next = answer["next"];
  }
  EXPECT_EQ(seen, 40);
  const Json newest = get("/api/v1/dwells");
  EXPECT_LT(newest["dwells"].size(), 40u);
  EXPECT_EQ(newest["dwells"].back()["index"], 40) << "without a page it is the newest that are left";
}

TEST_F(ApiTest, OneDwellIsHadByItsIndex) {
  finish(3);
  snapshot.dwell.index = 4;
  EXPECT_EQ(get("/api/v1/dwells/2")["index"], 2);
  EXPECT_EQ(get("/api/v1/dwells/2")["state"], "complete");
  EXPECT_EQ(get("/api/v1/dwells/4")["index"], 4) << "the current one too";
  const auto refused = [this](const char* path) {
    const HttpReply reply = http_answer(view(), path, "");
    EXPECT_EQ(reply.status, 404) << path;
    return Json::parse(reply.body)["error"].get<std::string>();
  };
  EXPECT_EQ(refused("/api/v1/dwells/99"), "dwell 99 has not been measured");
  for (const char* wrong : {"/api/v1/dwells/", "/api/v1/dwells/0", "/api/v1/dwells/-1", "/api/v1/dwells/x",
                            "/api/v1/dwells/1/", "/api/v1/dwells/99999999999999999999"})
    EXPECT_NE(refused(wrong).find("expected /api/v1/dwells/INDEX"), std::string::npos) << wrong;
  auto list = std::make_shared<FinishedDwells>(*snapshot.finished);
  list->erase(list->begin());
  snapshot.finished = list;
  EXPECT_EQ(refused("/api/v1/dwells/1"), "dwell 1 is no longer kept; the oldest that is has the index 2");
}

TEST_F(ApiTest, TheCurrentDwellHasItsTransientBesideItAndTheModelsVerdict) {
  EXPECT_TRUE(get("/api/v1/dwell")["motion"].is_null());
  EXPECT_TRUE(get("/api/v1/dwell")["model"].is_null());
  snapshot.dwell.index = 2;
  auto transient = std::make_shared<TransientEstimate>();
  transient->estimate.reason = "too few readings: 30";
  snapshot.transient = transient;
  EXPECT_TRUE(get("/api/v1/dwell")["motion"].is_null());
  EXPECT_EQ(get("/api/v1/dwell")["motion_reason"], "too few readings: 30");
  ModelVerdict adequate;
  adequate.verdict = Verdict::adequate;
  snapshot.models = std::make_shared<VerifiedModels>(VerifiedModels{{1, adequate}});
  EXPECT_TRUE(get("/api/v1/dwell")["model"].is_null()) << "it has not settled";
  snapshot.dwell.settled_s = 3.0;
  EXPECT_EQ(get("/api/v1/dwell")["model"]["verdict"], "not verified yet") << "the verified one is another";
  EXPECT_EQ(get("/api/v1/dwell")["model"]["asked"], 0.05);
  snapshot.dwell.index = 1;
  EXPECT_EQ(get("/api/v1/dwell")["model"]["verdict"], "adequate");
}

TEST_F(ApiTest, TheCurrentDwellTellsHowOldItIs) {
  EXPECT_NEAR(get("/api/v1/dwell")["estimate_age_s"].get<double>(), 0.1, 1e-9);
  EXPECT_EQ(get("/api/v1/dwell")["stale"], false);
  EXPECT_EQ(get("/api/v1/dwell")["doubts"], Json::array());
  snapshot.sequence = 0;
  EXPECT_TRUE(get("/api/v1/dwell")["estimate_age_s"].is_null()) << "nothing has been published";
  EXPECT_EQ(get("/api/v1/dwell")["stale"], true);
  finish(1);
  EXPECT_FALSE(get("/api/v1/dwells")["dwells"][0].contains("stale")) << "a finished dwell does not age";
}

// The estimation hangs: the service went on telling "kept" and "adequate", without a doubt.
TEST_F(ApiTest, AStaleDwellHasAReasonNotToRelyOnItAndNoVerdicts) {
  keep_a_limit(State::measuring);
  ModelVerdict adequate;
  adequate.verdict = Verdict::adequate;
  snapshot.models = std::make_shared<VerifiedModels>(VerifiedModels{{1, adequate}});
  const Json fresh = get("/api/v1/dwell");
  EXPECT_EQ(fresh["limits"][0]["verdict"], "kept");
  EXPECT_EQ(fresh["model"]["verdict"], "adequate");

  const auto expect_stale = [](const Json& dwell, const std::string& reason) {
    EXPECT_EQ(dwell["stale"], true);
    EXPECT_EQ(dwell["limits"][0]["verdict"], "none");
    EXPECT_NE(dwell["limits"][0]["reason"].get<std::string>().find(reason), std::string::npos) << dwell["limits"];
    EXPECT_TRUE(dwell["model"].is_null());
    EXPECT_EQ(dwell["doubts"][0]["what"], reason);
    EXPECT_EQ(dwell["doubts"][0]["elements"], Json::array()) << "it names every element";
  };
  expect_stale(Json::parse(http_answer(view("thread estimate has not turned for 3.0 s"), "/api/v1/dwell", "").body),
               "stale: the service itself does not work: thread estimate has not turned for 3.0 s");
  snapshot.t_ns = -1'000'000'000;  // 3 s ago
  expect_stale(get("/api/v1/dwell"), "stale: the estimation publishes nothing new");
}

// After `stop` with the drive on, the dwell that had ended still told "kept".
TEST_F(ApiTest, ADwellThatHasEndedKeepsItsVerdictsAndTheCurrentOneHasThemWhileItIsMeasured) {
  keep_a_limit(State::complete);
  snapshot.finished = std::make_shared<FinishedDwells>(1, std::make_shared<const Dwell>(snapshot.dwell));
  EXPECT_EQ(get("/api/v1/dwell")["limits"][0]["verdict"], "none");
  EXPECT_EQ(get("/api/v1/dwell")["limits"][0]["reason"], "the dwell has ended");
  EXPECT_EQ(get("/api/v1/dwells")["dwells"][0]["limits"][0]["verdict"], "kept");
  EXPECT_EQ(get("/api/v1/dwells/1")["limits"][0]["verdict"], "kept");
  const Json brief = Json::parse(http_answer(view(), "/api/v1/dwells", "brief=1").body);
  EXPECT_EQ(brief["dwells"][0]["limits"][0]["verdict"], "kept");
}

// A model that was adequate while its dwell was on was null once the next one had begun.
TEST_F(ApiTest, ADwellThatHasEndedKeepsTheVerdictOnItsModel) {
  keep_a_limit(State::complete);
  snapshot.finished = std::make_shared<FinishedDwells>(1, std::make_shared<const Dwell>(snapshot.dwell));
  snapshot.dwell.index = 2;
  const auto brief = [this] { return Json::parse(http_answer(view(), "/api/v1/dwells", "brief=1").body)["dwells"][0]; };
  EXPECT_EQ(get("/api/v1/dwells/1")["model"]["verdict"], "not verified yet");
  EXPECT_EQ(brief()["model"]["verdict"], "not verified yet");
  ModelVerdict adequate;
  adequate.verdict = Verdict::adequate;
  adequate.seen = 0.012;
  snapshot.models = std::make_shared<VerifiedModels>(VerifiedModels{{1, adequate}});
  EXPECT_EQ(get("/api/v1/dwells/1")["model"]["verdict"], "adequate");
  EXPECT_EQ(get("/api/v1/dwells")["dwells"][0]["model"]["seen"], 0.012);
  EXPECT_EQ(brief()["model"]["verdict"], "adequate");
}

TEST_F(ApiTest, BeforeThereIsAVerificationItSaysWhy) {
  Json answer = get("/api/v1/verification");
  EXPECT_EQ(answer["verdict"], "not verified yet");
  EXPECT_TRUE(answer["dwell"].is_null());
  EXPECT_EQ(answer["accuracy"]["asked"], 0.05);
  EXPECT_NE(answer["reasons"][0].get<std::string>().find("no dwell of this run has settled yet"), std::string::npos);
  snapshot.dwell.settled_s = 3.0;
  EXPECT_NE(get("/api/v1/verification")["reasons"][0].get<std::string>().find("being verified"), std::string::npos);
}

TEST_F(ApiTest, WhereTheRigFileAsksForNoLiveVerificationNothingSeemsToBeUnderWay) {
  verification.live = false;
  snapshot.dwell.settled_s = 3.0;
  const Json answer = get("/api/v1/verification");
  EXPECT_EQ(answer["verdict"], "not verified yet");
  EXPECT_NE(answer["reasons"][0].get<std::string>().find("live = false"), std::string::npos);
  EXPECT_TRUE(get("/api/v1/dwell")["model"].is_null());
}

TEST_F(ApiTest, HealthTellsOfLinesOfTheLogThatAreLost) {
  snapshot.channels[0].fault = Fault::none;
  ServiceView now = view();
  now.log = {500, 29, true, "No space left on device"};
  const Json health = Json::parse(http_answer(judged(now), "/api/v1/health", "").body);
  EXPECT_EQ(health["status"], "degraded");
  EXPECT_EQ(health["log"]["dropped"], 29);
  EXPECT_NE(health["reason"].get<std::string>().find("29"), std::string::npos) << health["reason"];
}

TEST_F(ApiTest, WhatIsNotServedIsNotFoundInWords) {
  for (const char* path : {"/", "/metrics/", "/api/v1/runs/", "/api/v1/dwell/", "/../etc/passwd"}) {
    const HttpReply reply = http_answer(view(), path, "");
    EXPECT_EQ(reply.status, 404) << path;
    EXPECT_TRUE(Json::parse(reply.body)["error"].is_string());
  }
}

TEST_F(ApiTest, ControlAnswersItsVerbs) {
  EXPECT_TRUE(control(R"({"verb":"status"})").contains("dwell"));
  const Json check = control(R"({"verb":"check"})")["channels"][0];
  EXPECT_EQ(check["unit"], "mm");
  EXPECT_EQ(check["device"], "amplifier");
  EXPECT_TRUE(check["latency_s"].is_null()) << "nothing received yet";
  EXPECT_EQ(control(R"({"verb":"rearm"})")["done"], true);
  EXPECT_EQ(control(R"({"verb":"start","label":"sweep 3","comment":"ä new damper"})")["done"], true);
  EXPECT_EQ(control(R"({"verb":"stop"})")["done"], true);
  EXPECT_EQ(control(R"({"verb":"label","label":"oil film"})")["done"], true);
  ASSERT_EQ(asked.size(), 4u);
  EXPECT_EQ(asked[3].verb, OperatorRequest::Verb::label);
  EXPECT_EQ(asked[1].verb, OperatorRequest::Verb::start);
  EXPECT_EQ(asked[1].label, "sweep 3");
  EXPECT_EQ(asked[1].comment, "ä new damper");
  EXPECT_EQ(asked[2].verb, OperatorRequest::Verb::stop);
}

TEST_F(ApiTest, ControlSaysWhatIsWrongWithALine) {
  for (const std::string& line :
       {std::string(), std::string("{"), std::string("[]"), std::string("{}"), std::string(R"({"verb":1})"),
        std::string(R"({"verb":"halt"})"), std::string(R"({"verb":"start"})"),
        std::string(R"({"verb":"start","label":3})"), std::string(R"({"verb":"stop","comment":"a\nb"})"),
        R"({"verb":"start","label":")" + std::string(201, 'x') + "\"}", std::string("\xff\xfe"),
        std::string(60'000, '['), std::string("{\"verb\":\"\xff\"}")})
    EXPECT_TRUE(control(line)["error"].is_string()) << line.substr(0, 40);
  EXPECT_TRUE(asked.empty());
}

TEST_F(ApiTest, WhatAnOperatorAsksForInVainIsSaid) {
  refusal = "too many at once; try again";
  for (const char* line : {R"({"verb":"rearm"})", R"({"verb":"start","label":"a"})", R"({"verb":"stop"})"})
    EXPECT_EQ(control(line)["error"], refusal);
}

TEST_F(ApiTest, HealthTellsWhetherARunIsRecordedAndThatIsNoFault) {
  snapshot.channels[0].fault = Fault::none;
  Json health = get("/api/v1/health");
  EXPECT_EQ(health["status"], "ok");
  EXPECT_EQ(health["run"]["recorded"], false);
  EXPECT_EQ(health["run"]["text"], "not recorded: the rig file has no [recording]");
  snapshot.run = {true, true, true, false, 3};
  health = get("/api/v1/health");
  EXPECT_EQ(health["run"]["begun_by"], "operator");
  snapshot.run = {true, false, false, true, 3};
  health = get("/api/v1/health");
  EXPECT_EQ(health["status"], "ok");
  EXPECT_TRUE(health["run"]["begun_by"].is_null());
  EXPECT_EQ(health["run"]["held"], true);
  EXPECT_NE(health["run"]["text"].get<std::string>().find("it was stopped"), std::string::npos);
}

TEST_F(ApiTest, HealthTellsOfTheLinesThatAreConfiguredAndIsDegradedByOneThatDoesNotWork) {
  snapshot.channels[0].fault = Fault::none;
  ServiceView now = view();
  EXPECT_EQ(Json::parse(http_answer(judged(now), "/api/v1/health", "").body)["gpio"], Json::object());
  now.gpio[0] = {true, true, "", true, 5, 1, 0};
  Json health = Json::parse(http_answer(judged(now), "/api/v1/health", "").body);
  EXPECT_EQ(health["status"], "ok");
  EXPECT_EQ(health["gpio"], Json::parse(R"({"interlock":{"works":true,"reason":null,"level":1,"edges":5,"bounces":1,
                                             "lost":0}})"));
  now.gpio[3] = {true, false, "there is no /dev/gpiochip0", std::nullopt, 0, 0, 0};
  health = Json::parse(http_answer(judged(now), "/api/v1/health", "").body);
  EXPECT_EQ(health["status"], "degraded");
  EXPECT_EQ(health["gpio"]["fault"]["reason"], "there is no /dev/gpiochip0");
  EXPECT_EQ(health["gpio"]["fault"]["level"], nullptr);
}

}  // namespace
}  // namespace dwell
