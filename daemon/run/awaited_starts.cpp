#include "daemon/run/awaited_starts.hpp"

#include <algorithm>
#include <utility>

namespace dwell {

void AwaitedStarts::add(std::uint16_t number, std::int64_t now_ns, std::function<void(const StartOutcome&)> tell) {
  awaited_.push_back({number, now_ns + kPatience_ns, std::move(tell)});
}

void AwaitedStarts::look(const record::RecorderState& recorder, std::int64_t now_ns) {
  if (awaited_.empty()) return;
  // Those before the newest that the recorder knows came through the stream before it: their runs have ended.
  const auto newest = std::find_if(awaited_.begin(), awaited_.end(),
                                   [&](const Awaited& one) { return one.number == recorder.newest_start; });
  const auto known = newest == awaited_.end() ? awaited_.begin() : newest + 1;
  std::vector<std::pair<Awaited, StartOutcome>> told;
  for (auto one = awaited_.begin(); one != known; ++one)
    told.emplace_back(std::move(*one),
                      StartOutcome{true, one == newest && !recorder.recording ? recorder.obstacle.why : std::string()});
  awaited_.erase(awaited_.begin(), known);
  while (!awaited_.empty() && awaited_.front().until_ns <= now_ns) {
    told.emplace_back(std::move(awaited_.front()), StartOutcome{});
    awaited_.erase(awaited_.begin());
  }
  for (const auto& [one, outcome] : told) one.tell(outcome);
}

}  // namespace dwell
