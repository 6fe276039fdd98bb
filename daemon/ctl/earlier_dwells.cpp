#include "daemon/ctl/earlier_dwells.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "daemon/ctl/json_member.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::ctl {
namespace {

constexpr int kPerAnswer = 100;  // the most that the service tells at once
constexpr int kMostAnswers =
    10;  // for the 1000 dwells that it keeps; a server that gives less at once gets no more questions

double value_of(const Json& element, const char* coefficient) {
  const Json* const object = member_of(element, coefficient);
  return object != nullptr ? number_member(*object, "value") : kNaN;
}

std::optional<EarlierDwell> earlier_dwell(const Json& item, std::int64_t now_ns) {
  const auto start_ns = record::parse_utc(text_member(item, "start_utc"));
  const double settled_s = number_member(item, "settled_s"), end_s = number_member(item, "end_s");
  const Json* const elements = member_of(item, "elements");
  if (!start_ns || !std::isfinite(settled_s) || !std::isfinite(end_s) || elements == nullptr || !elements->is_array())
    return std::nullopt;
  EarlierDwell dwell;
  dwell.index = static_cast<int>(count_member(item, "index"));
  const double now_s = 1e-9 * static_cast<double>(now_ns - *start_ns);
  dwell.settled_ago_s = now_s - settled_s;
  dwell.ended_ago_s = now_s - end_s;
  for (const Json& element : *elements) {
    dwell.stiffness.push_back(value_of(element, "stiffness"));
    dwell.damping.push_back(value_of(element, "damping"));
  }
  return dwell;
}

}  // namespace

std::vector<EarlierDwell> earlier_dwells(const Json& list, const std::string& utc, double span_s) {
  std::vector<EarlierDwell> dwells;
  const auto now_ns = record::parse_utc(utc);
  const Json* const items = member_of(list, "dwells");
  if (!now_ns || items == nullptr || !items->is_array()) return dwells;
  for (const Json& item : *items)
    if (auto dwell = earlier_dwell(item, *now_ns); dwell && dwell->ended_ago_s >= 0.0 && dwell->ended_ago_s < span_s)
      dwells.push_back(std::move(*dwell));
  return dwells;
}

std::optional<std::vector<EarlierDwell>> ask_earlier_dwells(const Asks& answer, const std::string& utc, double span_s) {
  const std::string path = "/api/v1/dwells?brief=1&count=" + std::to_string(kPerAnswer);
  auto list = answer(path);
  if (!list) return std::nullopt;
  std::vector<EarlierDwell> dwells = earlier_dwells(*list, utc, span_s);
  // Only the newest are told without an index, and an answer goes on to newer ones: each next one begins further back.
  for (int answers = 1; answers < kMostAnswers && !dwells.empty() && dwells.front().index > 1; ++answers) {
    const int end = dwells.front().index, begin = std::max(1, end - kPerAnswer);
    list = answer(path + "&from=" + std::to_string(begin));
    if (!list) break;
    std::vector<EarlierDwell> more = earlier_dwells(*list, utc, span_s);
    more.erase(std::remove_if(more.begin(), more.end(), [end](const EarlierDwell& d) { return d.index >= end; }),
               more.end());
    if (more.empty()) break;
    dwells.insert(dwells.begin(), more.begin(), more.end());
  }
  return dwells;
}

std::vector<EarlierRun> earlier_runs(const Json& list, const std::string& utc, double span_s) {
  std::vector<EarlierRun> runs;
  const auto now_ns = record::parse_utc(utc);
  const Json* const items = member_of(list, "runs");
  if (!now_ns || items == nullptr || !items->is_array()) return runs;
  for (auto item = items->rbegin(); item != items->rend() && runs.size() < kMostRuns; ++item) {
    const auto ended_ns = record::parse_utc(text_member(*item, "ended"));
    const std::string path = text_member(*item, "dwells_at");
    if (!ended_ns || path.empty() || 1e-9 * static_cast<double>(*now_ns - *ended_ns) > span_s) continue;
    runs.push_back({"run " + integer_text(*item, "run"), path + "?count=" + std::to_string(kPerAnswer)});
  }
  return runs;
}

}  // namespace dwell::ctl
