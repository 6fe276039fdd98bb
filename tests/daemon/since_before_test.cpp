// What the service says of how the coefficients differ from those of the settled dwell before.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "daemon/record/utc_text.hpp"
#include "daemon/serve/api.hpp"
#include "tests/ctl/sample_dwell.hpp"

namespace dwell {
namespace {

using Json = nlohmann::json;

// Dwell 3 of a run is measured; two have ended before it.
struct SinceBeforeTest : testing::Test {
  SinceBeforeTest() {
    snapshot.sequence = 1;
    snapshot.t_ns = 1'900'000'000;
    snapshot.channels.resize(rig.channels.size());
    snapshot.dwell = test::sample_dwell();
    snapshot.dwell.index = 3;
    snapshot.dwell.elements[0].stiffness.value *= 1.01;
    end({before(1, 20.0), before(2, 40.0)});
  }
  // A dwell that ended then.
  static Dwell before(int index, double end_s) {
    Dwell dwell = test::sample_dwell();
    dwell.index = index;
    dwell.state = State::complete;
    dwell.ended_by = EndedBy::drive_changed;
    dwell.end_s = end_s;
    return dwell;
  }
  void end(std::vector<Dwell> dwells) {
    auto list = std::make_shared<FinishedDwells>();
    for (Dwell& dwell : dwells) list->push_back(std::make_shared<const Dwell>(std::move(dwell)));
    snapshot.finished = list;
  }
  [[nodiscard]] Json since() const {
    ServiceView now{rig, run, snapshot};
    now.now_ns = 2'000'000'000;
    return Json::parse(http_answer(now, "/api/v1/dwell", "").body)["since"];
  }

  Rig rig = test::sample_rig();
  RunInfo run = test::sample_run();
  Snapshot snapshot;
};

TEST_F(SinceBeforeTest, TheNewestDwellBeforeIsComparedWithAndNamed) {
  const Json told = since();
  EXPECT_EQ(told["index"], 2);
  EXPECT_EQ(told["end_s"], 40.0);
  EXPECT_EQ(told["start_utc"], run.start_utc);
  ASSERT_EQ(told["elements"].size(), 2U) << "element 2 has no coefficients";
  const Json& first = told["elements"][0];
  EXPECT_EQ(first["k"], 1);
  EXPECT_NEAR(first["stiffness"]["change"].get<double>(), 0.01, 1e-12);
  EXPECT_NEAR(first["stiffness"]["U95"].get<double>(), std::sqrt(2.0) * 27.4 / 24010.0, 1e-9);
  EXPECT_EQ(first["stiffness"]["moved"], true);
  EXPECT_EQ(first["damping"]["change"], 0.0);
  EXPECT_EQ(first["damping"]["moved"], false);
}

TEST_F(SinceBeforeTest, ADwellThatNeverSettledIsPassedOver) {
  Dwell never = before(2, 40.0);
  never.settled_s = kNaN;
  never.elements.clear();
  end({before(1, 20.0), never});
  EXPECT_EQ(since()["index"], 1);
}

// After its end a dwell is in the list while it may still be the current one.
TEST_F(SinceBeforeTest, ADwellIsNotComparedWithItself) {
  end({before(3, 60.0)});
  EXPECT_TRUE(since().is_null());
}

TEST_F(SinceBeforeTest, TheFirstDwellOfARunIsComparedWithTheLastOfAnEarlierRun) {
  end({});
  EXPECT_TRUE(since().is_null());
  snapshot.earlier = {std::make_shared<const Dwell>(before(7, 90.0)), *record::parse_utc("2026-11-20T06:00:00Z")};
  EXPECT_EQ(since()["index"], 7);
  EXPECT_EQ(since()["start_utc"], "2026-11-20T06:00:00.000000Z");
}

TEST_F(SinceBeforeTest, WithoutANumberBeforeThereIsNothingToCompareWith) {
  Dwell withheld = before(2, 40.0);
  withheld.elements[0].identifiable = false;
  withheld.elements[2].stiffness.value = 0.0;
  end({withheld});
  const Json told = since();
  EXPECT_TRUE(told["elements"][0]["stiffness"].is_null());
  EXPECT_TRUE(told["elements"][0]["damping"].is_null());
  EXPECT_TRUE(told["elements"][1]["stiffness"].is_null());
  EXPECT_FALSE(told["elements"][1]["damping"].is_null());
}

TEST_F(SinceBeforeTest, ADwellThatIsNotMeasuredIsNotCompared) {
  snapshot.dwell.state = State::complete;
  EXPECT_TRUE(since().is_null());
  snapshot.dwell = test::settling_dwell();
  EXPECT_TRUE(since().is_null());
}

}  // namespace
}  // namespace dwell
