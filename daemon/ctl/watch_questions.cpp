#include "daemon/ctl/watch_questions.hpp"

#include <algorithm>
#include <utility>

#include "daemon/ctl/json_member.hpp"
#include "daemon/ctl/tables.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json.hpp"

namespace dwell::ctl {

void Questions::stream_began() {
  next_s_ = now_s_() + kEvery_s;
  knows_earlier_ = knows_runs_ = knows_since_ = knows_last_ = false;
}

void Questions::turn(WatchState& state) {
  if (now_s_() < next_s_) return;
  const auto channels = asks_("/api/v1/channels");
  const auto alarms = channels ? asks_("/api/v1/alarms") : channels;
  // A refusal leaves what was known before, which grows old.
  if (alarms)
    if (auto list = alarms_from_json(*alarms)) state.take(std::move(*list), now_s_());
  const auto health = channels ? asks_("/api/v1/health") : channels;
  next_s_ = now_s_() + (health ? kEvery_s : kSilent_s);
  if (!health) return;
  if (const Json* const list = member_of(*channels, "channels")) state.take(channel_states(*list), now_s_());
  const std::string rig = text_member(*health, "rig"), sha256 = text_member(*health, "rig_sha256");
  if (!rig.empty() && !sha256.empty() && state.take_rig(rig, sha256))
    knows_earlier_ = knows_runs_ = knows_since_ = knows_last_ = false;
  const std::string utc = text_member(*health, "utc");
  if (const auto utc_ns = record::parse_utc(utc)) state.take_utc(*utc_ns, now_s_());
  state.take_played(played(*health));
  ask_earlier(state, utc);
  ask_unverified(state);
  ask_since(state);
  ask_last(state);
  state.take_run(run_text(*health));
  if (health->is_object() && health->contains("gpio")) state.take_gpio(gpio_text(*health), now_s_());
  ask_runs(state, utc, sha256);
}

// While the dwell's model has no verdict: why.
void Questions::ask_unverified(WatchState& state) const {
  const auto& view = state.dwell();
  if (!view || !view->model || view->model->verdict != Verdict::not_verified) return;
  if (const auto answer = asks_("/api/v1/verification")) state.take(why_unverified(*answer));
}

// Asks since when the state is so, once for each state. Only where the dwell does not tell it.
void Questions::ask_since(WatchState& state) {
  if (knows_since_ || !state.dwell() || state.since_utc_ns()) return;
  knows_since_ = true;
  const State now = state.dwell()->dwell.state;
  if (const auto answer = asks_("/api/v1/events"))
    if (const auto utc_ns = state_since(*answer, now)) state.take_since(now, *utc_ns);
}

// Asks how the last dwell ended, and for the verdicts on it, once whenever none is measured.
void Questions::ask_last(WatchState& state) {
  if (knows_last_ || !state.dwell()) return;
  const State now = state.dwell()->dwell.state;
  knows_last_ = true;
  if (now != State::idle && now != State::fault && now != State::complete) return;
  const auto list = asks_("/api/v1/dwells?count=1");
  const Json* const dwells = list ? member_of(*list, "dwells") : nullptr;
  if (dwells == nullptr || !dwells->is_array() || dwells->empty()) return;
  if (auto last = parse_dwell(dwells->back().dump())) state.take_last(std::move(*last));
}

// Once for each stream: the dwells of the last hour, for the trend. utc: the service's now.
void Questions::ask_earlier(WatchState& state, const std::string& utc) {
  if (knows_earlier_) return;
  const auto dwells = ask_earlier_dwells(asks_, utc, Trend::kSpan_s);
  if (dwells) state.take(*dwells, now_s_());
  knows_earlier_ = dwells.has_value();
}

// The service's list of dwells begins anew with each run: those of earlier runs are in their files. One file a turn,
// since the service may have to read it first.
void Questions::ask_runs(WatchState& state, const std::string& utc, const std::string& rig_sha256) {
  if (!knows_runs_) {
    const auto list = asks_("/api/v1/runs");
    if (!list) return;
    knows_runs_ = true;
    runs_.clear();
    lacking_.clear();
    for (EarlierRun& run : earlier_runs(*list, utc, Trend::kSpan_s)) runs_.push_back({std::move(run)});
  } else if (!runs_.empty()) {
    Untold one = std::move(runs_.front());
    runs_.erase(runs_.begin());
    const auto answer = asks_(one.run.dwells_at);
    if (!answer) {
      if (++one.tries < kTries)
        runs_.push_back(std::move(one));
      else
        lacking_.push_back(one.run.name);
    } else if (text_member(*answer, "rig_sha256") == rig_sha256) {
      state.take(earlier_dwells(*answer, utc, Trend::kSpan_s), now_s_());
    }
  }
  state.take_lacking(lacking_);
}

}  // namespace dwell::ctl
