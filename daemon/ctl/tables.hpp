// The tables of dwellctl that are not a single dwell: channels, dwells, a check. Made from the service's JSON, so they
// take whatever it holds: what is missing or of another type is shown as "—".
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/result/dwell.hpp"
#include "daemon/report/dwell_view.hpp"

namespace dwell::ctl {

// `list`: an array of the interface's channel objects. The status stands beside the name, its reason at the end.
[[nodiscard]] std::string channels_table(const nlohmann::ordered_json& list);

// `health`: the interface's health object. A line for each reason why runs are not recorded, or are not as they should
// be; empty: there is none.
[[nodiscard]] std::string recording_text(const nlohmann::ordered_json& health);

// `health`: the interface's health object. What an operator must know of the GPIO lines: how the interlock stands, and
// which lines do not work; empty: no interlock, and all work.
[[nodiscard]] std::string gpio_text(const nlohmann::ordered_json& health);

// One line per element of each dwell; above it what must not be relied on, below it what its ± and marks mean.
[[nodiscard]] std::string dwells_table(const std::vector<DwellView>& dwells);

// `runs`: the interface's object of runs. Where the dwells of earlier runs are; empty: there are none.
[[nodiscard]] std::string earlier_runs_text(const nlohmann::ordered_json& runs);

// One channel probed once.
struct Probed {
  std::string name;
  std::string device;
  double value = kNaN;      // in `unit`
  std::string unit;         // as in the rig file
  double rate_hz = kNaN;    // attainable; by the running service: attained
  double latency_s = kNaN;  // from request to answer
  std::string status;       // "ok", what is wrong with its readings ("gated"), or why there are none ("no answer")
  std::string reason;       // in words; empty: none is known
  // Whether its device answers. The readings may be of no use ("stuck").
  [[nodiscard]] bool answers() const;
  // Whether its readings do not fit its motion: the rig file may state a wrong type or order of its register.
  [[nodiscard]] bool gated() const;
};
[[nodiscard]] std::string check_table(const std::vector<Probed>& channels);
[[nodiscard]] nlohmann::ordered_json check_json(const std::vector<Probed>& channels);
[[nodiscard]] std::vector<Probed> probed_from_json(const nlohmann::ordered_json& list);

}  // namespace dwell::ctl
