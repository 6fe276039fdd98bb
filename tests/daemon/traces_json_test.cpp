// What GET /api/v1/traces answers, and what a live stream that asks for traces is told.
#include "daemon/serve/traces_json.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/api_schema.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/daemon/one_mass_rig.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

using Parsed = nlohmann::json;

struct TracesJsonTest : testing::Test {
  TracesJsonTest() {
    rig.channels[0].name = "y0";
    rig.channels[1].name = "left & right";
    traces = Traces(rig);
    for (std::int64_t i = 0; i < 400; ++i)
      for (std::uint16_t c = 0; c < 2; ++c)
        if (c == 0 || i != 200)
          traces.take({.t_ns = 10 * i * kMs_ns + kMs_ns,
                       .value = static_cast<double>(i % 7 + c),
                       .channel = c,
                       .flags = c == 1 && i == 201 ? kGap : std::uint8_t{0}});
  }
  [[nodiscard]] HttpReply get(const std::string& query) {
    ServiceView now{rig, run, snapshot};
    now.now_ns = 5'000 * kMs_ns;
    now.now_utc_ns = 1'700'000'000'000'000'000;
    now.traces = &traces;
    return traces_answer(now, query);
  }
  [[nodiscard]] Parsed json(const std::string& query) { return Parsed::parse(get(query).body); }

  test::ApiSchema schema;
  Rig rig = test::one_mass_rig();
  RunInfo run;
  Snapshot snapshot;
  Traces traces{rig};
};

TEST_F(TracesJsonTest, AnswersWhatIsKept) {
  const Parsed answer = json("from=1&to=1.99&points=50");
  EXPECT_EQ(schema.faults_of_text("traces", answer.dump()), "");
  EXPECT_EQ(answer["step_s"], 0.02);
  EXPECT_EQ(answer["from_s"], 1.0);
  EXPECT_EQ(answer["bins"], 50);
  EXPECT_EQ(answer["origin_utc"], "2023-11-14T22:13:15.001000Z");
  ASSERT_EQ(answer["channels"].size(), 2U);
  EXPECT_EQ(answer["channels"][0]["name"], "y0");
  EXPECT_EQ(answer["channels"][0]["min"][0], 2);  // readings 100 and 101, modulo 7
  EXPECT_EQ(answer["channels"][0]["max"][0], 3);
  EXPECT_EQ(answer["less_from_s"], nullptr);
}

TEST_F(TracesJsonTest, SaysWhereATraceBreaks) {
  const Parsed answer = json("from=1.9&to=2.1&points=11&channels=left%20%26%20right");
  ASSERT_EQ(answer["channels"].size(), 1U);
  EXPECT_EQ(answer["channels"][0]["breaks"], Parsed::array({5}));
}

TEST_F(TracesJsonTest, NegativeTimesAreBeforeTheNewestReading) {
  const Parsed answer = json("from=-1&points=51");
  EXPECT_NEAR(answer["newest_s"].get<double>(), 3.99, 1e-9);
  EXPECT_NEAR(answer["from_s"].get<double>(), 2.98, 0.011);
  EXPECT_EQ(json("from=-2&to=-1&points=51")["from_s"], 1.98);
}

TEST_F(TracesJsonTest, AnAnswerIsBoundedWhateverIsAsked) {
  for (const char* query :
       {"points=4000", "from=0&to=1e300&points=4000", "from=-1e300&to=1e300", "from=3.9&to=3.9", "from=3.9"}) {
    const Parsed answer = json(query);
    EXPECT_LE(answer["bins"].get<std::int64_t>(), kMostTracePoints) << query;
    EXPECT_EQ(answer["channels"][1]["max"].size(), answer["bins"].get<std::size_t>()) << query;
  }
}

TEST_F(TracesJsonTest, WhatIsNotUnderstoodIsNamedWithWhatWasExpected) {
  for (const char* query : {"from=x", "to=inf", "from=nan", "points=0", "points=-1", "points=2.5",
                            "channels=", "channels=y9", "channels=y0,y0", "less=transient", "?", "from=1,2",
                            "points=4001", "from=1&from=2", "less=steady&less=steady"}) {
    const HttpReply reply = get(query);
    EXPECT_EQ(reply.status, 400) << query;
    EXPECT_NE(reply.body.find("expected from=SECONDS"), std::string::npos) << query;
  }
  EXPECT_NE(get("from=1&from=2").body.find("from is given twice"), std::string::npos);
  const auto why = [&](const char* query) {
    return std::to_string(get(query).status) + " " + json(query)["error"].get<std::string>();
  };
  EXPECT_EQ(why("from=3&to=2"), "400 to=2 is before from=3 (s): expected a later one");
  EXPECT_EQ(why("from=100&to=200"), "400 from=100 is in the future: the newest record is at 3.99 s");
}

TEST_F(TracesJsonTest, WithoutAnEndTheStretchGoesToTheNewestReading) {
  const Parsed answer = json("from=3&points=4000");
  EXPECT_EQ(answer["from_s"], 3.0);
  EXPECT_NEAR(answer["from_s"].get<double>() + answer["bins"].get<double>() * answer["step_s"].get<double>(), 4.0,
              0.02);
  EXPECT_EQ(get("from=3.99").status, 200) << "who follows asks from the newest on";
}

TEST_F(TracesJsonTest, WithoutASettledDwellThereIsNoSteadyPart) {
  EXPECT_EQ(get("less=steady").status, 409);
  rig = test::sample_rig();
  traces = Traces(rig);
  EXPECT_EQ(get("").status, 503) << "nothing has come yet";
  traces.take({.t_ns = 0, .kind = Kind::tick});
  snapshot.dwell = test::sample_dwell();
  const Parsed answer = json("less=steady");
  EXPECT_EQ(answer["less_dwell"], *snapshot.dwell.index);
  EXPECT_DOUBLE_EQ(answer["less_from_s"].get<double>(), snapshot.dwell.settled_s);
  EXPECT_EQ(schema.faults_of_text("traces", answer.dump()), "");
}

TEST_F(TracesJsonTest, ALiveStreamIsToldOfCompleteBinsAlone) {
  const Parsed event = Parsed::parse(traces_event(traces, 190, 2));
  EXPECT_EQ(schema.faults_of_text("traces_event", event.dump()), "");
  EXPECT_EQ(event["first"], 190);
  EXPECT_EQ(event["bins"], 9) << "the bin of 3.98 s to 4 s is not complete at 3.99 s";
  const Parsed answer = json("from=3.8&to=3.97&points=9");
  EXPECT_EQ(event["channels"][1]["min"], answer["channels"][1]["min"]);
}

}  // namespace
}  // namespace dwell
