// What the outlets make of events and of how the service stands.
#include "daemon/outlets/outlet.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "daemon/notifier.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/daemon/log_to_read.hpp"

namespace dwell {
namespace {

struct OutletTest : testing::Test {
  OutletTest() {
    snapshot.dwell.index = 3;
    snapshot.dwell.state = State::measuring;
    snapshot.dwell.frequency_hz.value = 4.0003;
  }
  [[nodiscard]] ServiceView view() const {
    ServiceView now{rig, run, snapshot};
    now.health = health;
    now.now_ns = 7'000'000'000;
    return now;
  }
  static RunEvent event(RunEvent::Kind kind, State state, State before = State::idle) {
    Dwell dwell;
    dwell.index = 3;
    dwell.state = state;
    dwell.settling_reason = "the drive has stopped";
    dwell.ended_by = EndedBy::end;
    return {kind, before, std::make_shared<const Dwell>(dwell)};
  }

  Rig rig;
  RunInfo run;
  Snapshot snapshot;
  Health health{};
};

TEST_F(OutletTest, TheLogTellsOfEveryChangeAndEveryFinishedDwell) {
  test::LogToRead log("outlet");
  const auto lines = make_log_lines(log);
  lines->tell(event(RunEvent::Kind::state_changed, State::settling), rig);
  lines->tell(event(RunEvent::Kind::dwell_finished, State::complete, State::settling), rig);
  lines->show(view());
  EXPECT_EQ(log.lines(), (std::vector<std::string>{
                             "info state idle -> settling, dwell 3: the drive has stopped",
                             "info dwell 3 complete (end): never settled, the drive has stopped",
                         }));
}

TEST_F(OutletTest, TheLogTellsOfADoubtedDwellAsAWarningWithItsReasonAndWhatItsUncertaintyDoesNotCover) {
  test::LogToRead log("outlet-doubt");
  Dwell dwell = test::sample_dwell();
  dwell.index = 4;
  dwell.state = State::complete;
  dwell.doubts = {{{1}, "the poles contradict"}};
  dwell.unstated = {"mass 1"};
  make_log_lines(log)->tell({RunEvent::Kind::dwell_finished, State::measuring, std::make_shared<const Dwell>(dwell)},
                            test::sample_rig());
  const std::string line = log.lines().at(0);
  EXPECT_EQ(line.find("warning dwell 4 complete"), 0u) << line;
  EXPECT_NE(line.find(" (do not rely on it); "), std::string::npos) << line;
  EXPECT_EQ(line.find(" (do not rely on it)"), line.rfind(" (do not rely on it)")) << "of element 1 alone: " << line;
  EXPECT_NE(line.find("; doubt: the poles contradict"), std::string::npos) << line;
  EXPECT_NE(line.find("not stated: mass 1"), std::string::npos) << line;
}

TEST_F(OutletTest, TheLogSaysHowManyEventsItWasNotToldOf) {
  test::LogToRead log("outlet-lost");
  RunEvent late = event(RunEvent::Kind::state_changed, State::settling);
  late.lost = 6;
  make_log_lines(log)->tell(late, rig);
  EXPECT_EQ(log.lines().front(), "warning 6 changes of state or finished dwells are missing here");
}

TEST_F(OutletTest, TheLampsShowTheHealthAndNothingElse) {
  gpio::Link lines;
  const auto lamps = make_lamps(lines);
  for (const auto status : {Health::Status::ok, Health::Status::degraded, Health::Status::fault}) {
    for (const bool ready : {false, true}) {
      health.status = status;
      health.ready = ready;
      lamps->show(view());
      EXPECT_EQ(lines.order().ready, ready);
      EXPECT_EQ(lines.order().fault, status != Health::Status::ok);
      EXPECT_EQ(lines.ordered_ns(), 7'000'000'000) << "said anew: a hanging service blinks nothing";
    }
  }
}

// Notes what it is told, and fails where it is asked to.
struct Noting : Outlet {
  explicit Noting(bool fails = false) : failing(fails) {}
  void show(const ServiceView& /*now*/) override {
    ++shown;
    if (failing) throw std::runtime_error("no room for the answer");
  }
  void tell(const RunEvent& /*event*/, const Rig& /*rig*/) override {}
  bool failing;
  int shown = 0;
};

TEST_F(OutletTest, OneThatFailsKeepsNoneOfTheOthersFromTheirTurnAndIsToldOf) {
  Noting first(true), second, third(true);
  try {
    call_each({&first, nullptr, &second, &third}, [&](Outlet& outlet) { outlet.show(view()); });
    ADD_FAILURE() << "the failure is told of";
  } catch (const std::runtime_error& failure) {
    EXPECT_STREQ(failure.what(), "no room for the answer");
  }
  EXPECT_EQ(first.shown + second.shown + third.shown, 3);
}

}  // namespace
}  // namespace dwell
