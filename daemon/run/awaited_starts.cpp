#include "daemon/run/awaited_starts.hpp"

#include <algorithm>
#include <utility>

namespace dwell {
namespace {

// Of the newest start that the recorder has seen.
StartOutcome outcome_of(const record::RecorderState& recorder) {
  if (recorder.recording) return {StartOutcome::Is::recorded, ""};
  if (recorder.obstacle.why.empty()) return {};
  return {StartOutcome::Is::not_recorded, recorder.obstacle.why};
}

}  // namespace

void AwaitedStarts::add(std::uint16_t number, std::int64_t now_ns, std::function<void(const StartOutcome&)> tell) {
  awaited_.push_back({number, now_ns + patience_ns_, std::move(tell)});
}

void AwaitedStarts::look(const record::RecorderState& recorder, std::int64_t now_ns) {
  if (awaited_.empty()) return;
  // Requests before the newest came through the stream before it. Their runs are over: nothing is known of them now.
  const auto newest = std::find_if(awaited_.begin(), awaited_.end(),
                                   [&](const Awaited& one) { return one.number == recorder.newest_start; });
  const auto behind = newest == awaited_.end() ? awaited_.begin() : newest + 1;
  std::vector<std::pair<Awaited, StartOutcome>> told;
  for (auto one = awaited_.begin(); one != behind; ++one)
    told.emplace_back(std::move(*one), one == newest ? outcome_of(recorder) : StartOutcome{});
  awaited_.erase(awaited_.begin(), behind);
  while (!awaited_.empty() && awaited_.front().until_ns <= now_ns) {
    told.emplace_back(std::move(awaited_.front()), StartOutcome{});
    awaited_.erase(awaited_.begin());
  }
  for (const auto& [one, outcome] : told) one.tell(outcome);
}

}  // namespace dwell
