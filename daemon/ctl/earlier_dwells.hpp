// The dwells that have ended, for watch's trend of the last hour: those of the run that goes on, which
// /api/v1/dwells?brief=1 tells, the newest 1000 of them; and those of earlier runs, which /api/v1/runs/FILE/dwells
// tells.
//
// Bound to one thread, not real-time: allocates.
#pragma once

#include <cstddef>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace dwell::ctl {

struct EarlierDwell {
  int index = 0;
  double settled_ago_s = 0.0, ended_ago_s = 0.0;  // from when and until when its data count, s before now
  std::vector<double> stiffness, damping;         // one per element; NaN: none
};

// Those of the list that ended in the last `span_s` and had settled, oldest first. What is no such dwell is left out.
// utc: the service's now.
[[nodiscard]] std::vector<EarlierDwell> earlier_dwells(const nlohmann::ordered_json& list, const std::string& utc,
                                                       double span_s);

// Asks for one part of the list after the other, the newest first, until the span or the first dwell is reached: at
// most as often as the service has parts. nullopt: the first question had no answer. Asks: returns the answer to a
// question for the path; nullopt: there is none.
using Asks = std::function<std::optional<nlohmann::ordered_json>(const std::string& path)>;
[[nodiscard]] std::optional<std::vector<EarlierDwell>> ask_earlier_dwells(const Asks& answer, const std::string& utc,
                                                                          double span_s);

// A run whose dwells the service reads from its file.
struct EarlierRun {
  std::string name;       // "run 7"
  std::string dwells_at;  // path that tells its newest dwells
};

// Those of the list of runs that ended in the last `span_s`, the newest first, at most kMostRuns. What is no such run
// is left out. utc: the service's now.
inline constexpr std::size_t kMostRuns = 20;
[[nodiscard]] std::vector<EarlierRun> earlier_runs(const nlohmann::ordered_json& list, const std::string& utc,
                                                   double span_s);

}  // namespace dwell::ctl
