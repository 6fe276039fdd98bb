// What watch asks the service beside its stream: channels, alarms, health, why a model has no verdict, since when the
// state is so, how the last dwell ended, and the dwells of the last hour.
//
// Bound to one thread, not real-time. A turn waits for each answer, and keys wait with it.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/ctl/earlier_dwells.hpp"
#include "daemon/ctl/watch_state.hpp"

namespace dwell::ctl {

class Questions {
 public:
  // From a turn's answers to the next turn, s.
  static constexpr double kEvery_s = 1.0;
  // Who does not answer is asked less often, since keys wait for the answer.
  static constexpr double kSilent_s = 10.0;
  // How often the dwells of a run are asked for that the service does not tell in time. It may read a long file
  // meanwhile.
  static constexpr int kTries = 3;

  // asks: waits for the answer for a second at most.
  // now_s: the clock of WatchState.
  Questions(Asks asks, std::function<double()> now_s) : asks_(std::move(asks)), now_s_(std::move(now_s)) {}

  // The stream has begun, anew perhaps: dwells may have ended meanwhile. Its first word comes before any question.
  void stream_began();
  // The stream told another dwell or state.
  void state_changed() { knows_since_ = knows_last_ = false; }
  // Asks what is due, and puts the answers into the state.
  void turn(WatchState& state);

 private:
  struct Untold {
    EarlierRun run;
    int tries = 0;
  };

  void ask_unverified(WatchState& state) const;
  void ask_since(WatchState& state);
  void ask_last(WatchState& state);
  void ask_earlier(WatchState& state, const std::string& utc);
  void ask_runs(WatchState& state, const std::string& utc, const std::string& rig_sha256);

  Asks asks_;
  std::function<double()> now_s_;
  double next_s_ = 0.0;
  bool knows_earlier_ = false;        // the dwells of the last hour in the service's list
  bool knows_runs_ = false;           // the runs of the last hour
  bool knows_since_ = false;          // since when the state is so, or that nobody tells it
  bool knows_last_ = false;           // the last dwell, where there is none now
  std::vector<Untold> runs_;          // whose dwells are still to be asked for, newest first
  std::vector<std::string> lacking_;  // runs whose dwells are not told
};

}  // namespace dwell::ctl
