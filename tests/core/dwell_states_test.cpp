// The dwell's state machine: what leads from one state to another, and what outsiders see of it.
#include "core/dwell/dwell_states.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <vector>

namespace dwell {
namespace {

void measure(DwellStates& states) {
  states.arm();
  states.begin_to_measure();
}

TEST(DwellStates, OutsidersSeeFourStatesOfTheNine) {
  EXPECT_EQ(state_of(Phase::idle), State::idle);
  EXPECT_EQ(state_of(Phase::interlocked), State::idle);
  EXPECT_EQ(state_of(Phase::unseen), State::fault);
  EXPECT_EQ(state_of(Phase::unseen_interlocked), State::fault);
  for (const Phase phase :
       {Phase::settling, Phase::unconfirmed, Phase::settling_after_change, Phase::unconfirmed_after_change})
    EXPECT_EQ(state_of(phase), State::settling) << static_cast<int>(phase);
  EXPECT_EQ(state_of(Phase::measuring), State::measuring);
}

TEST(DwellStates, ADriveThatIsSeenArmsADwellThatSettlesAndMeasures) {
  DwellStates states;
  EXPECT_TRUE(states.at_rest());
  states.arm();
  EXPECT_EQ(states.phase(), Phase::settling);
  EXPECT_EQ(states.index(), 1);
  EXPECT_TRUE(states.changed());
  EXPECT_FALSE(states.changed()) << "told once";
  states.set_unconfirmed(true);
  EXPECT_TRUE(states.unconfirmed() && states.settling());
  EXPECT_FALSE(states.changed()) << "outsiders see nothing of it";
  states.begin_to_measure();
  EXPECT_EQ(states.phase(), Phase::measuring);
  EXPECT_TRUE(states.changed());
}

TEST(DwellStates, NothingBeginsWhileTheInterlockIsOpen) {
  DwellStates states;
  states.interlock(false);
  EXPECT_EQ(states.phase(), Phase::interlocked);
  states.arm();
  EXPECT_EQ(states.phase(), Phase::interlocked);
  EXPECT_EQ(states.index(), 0);
  states.lose_sight();
  EXPECT_EQ(states.phase(), Phase::unseen_interlocked);
  states.interlock(true);
  EXPECT_EQ(states.phase(), Phase::unseen);
  states.arm();
  EXPECT_EQ(states.phase(), Phase::settling);
}

TEST(DwellStates, ATableThatMovesWithoutItsReferenceIsUnseenAndInterlockedItStaysSo) {
  DwellStates states;
  states.bar();
  EXPECT_EQ(states.phase(), Phase::unseen);
  states.interlock(false);
  states.bar();
  EXPECT_EQ(states.phase(), Phase::interlocked);
}

TEST(DwellStates, ADriveThatLeavesItsHoldWhileSettlingIsTheSameDwellAgain) {
  DwellStates states;
  states.arm();
  states.set_unconfirmed(true);
  states.leave_hold();
  EXPECT_EQ(states.phase(), Phase::settling);
  EXPECT_EQ(states.restarts(), 1);
  EXPECT_EQ(states.index(), 1);
}

TEST(DwellStates, ADriveThatLeavesItsHoldWhileMeasuringArmsTheNextAndTheFirstAwaitsItsReason) {
  DwellStates states;
  measure(states);
  states.leave_hold();
  EXPECT_EQ(states.phase(), Phase::settling_after_change);
  EXPECT_TRUE(states.awaits_reason());
  EXPECT_EQ(states.index(), 2);
  EXPECT_EQ(states.restarts(), 0);
  states.set_unconfirmed(true);
  EXPECT_EQ(states.phase(), Phase::unconfirmed_after_change);
  states.begin_to_measure();
  EXPECT_EQ(states.phase(), Phase::unconfirmed_after_change) << "not before the reason is known";
  states.go_on();
  EXPECT_FALSE(states.awaits_reason());
  states.begin_to_measure();
  EXPECT_EQ(states.phase(), Phase::measuring);
}

TEST(DwellStates, ADriveThatStopsAfterItsChangeHadNoSecondDwell) {
  DwellStates states;
  measure(states);
  states.leave_hold();
  states.forget_dwell();
  states.go_on();
  states.rest();
  EXPECT_EQ(states.phase(), Phase::idle);
  EXPECT_EQ(states.index(), 1);
}

TEST(DwellStates, AVerdictThatIsTakenBackSettlesAgainInTheSameDwell) {
  DwellStates states;
  measure(states);
  states.take_back();
  EXPECT_EQ(states.phase(), Phase::settling);
  EXPECT_EQ(states.index(), 1);
}

TEST(DwellStates, AnEventThatMeansNothingInAStateLeavesItAsItIs) {
  using Event = std::function<void(DwellStates&)>;
  const std::vector<Event> of_a_dwell = {
      [](DwellStates& s) { s.leave_hold(); },          [](DwellStates& s) { s.settle_anew(); },
      [](DwellStates& s) { s.set_unconfirmed(true); }, [](DwellStates& s) { s.begin_to_measure(); },
      [](DwellStates& s) { s.take_back(); },           [](DwellStates& s) { s.go_on(); }};
  for (const Event& event : of_a_dwell) {
    DwellStates states;
    event(states);
    EXPECT_EQ(states.phase(), Phase::idle);
    EXPECT_EQ(states.index(), 0);
  }
  const std::vector<Event> of_rest = {[](DwellStates& s) { s.arm(); },
                                      [](DwellStates& s) { s.bar(); },
                                      [](DwellStates& s) { s.interlock(false); },
                                      [](DwellStates& s) { s.settle_anew(); },
                                      [](DwellStates& s) { s.set_unconfirmed(true); },
                                      [](DwellStates& s) { s.go_on(); }};
  for (const Event& event : of_rest) {
    DwellStates states;
    measure(states);
    event(states);
    EXPECT_EQ(states.phase(), Phase::measuring);
    EXPECT_EQ(states.index(), 1);
  }
}

}  // namespace
}  // namespace dwell
