// The recorder in the service's answers: the object in the health, and the list of runs. Pure, as api.hpp. Heavy:
// include it in .cpp only.
#pragma once

#include <string>
#include <string_view>

#include "daemon/report/dwell_json_value.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

// The recorder's state; null if the service has none.
[[nodiscard]] Json recorder_json(const ServiceView& view);

// The path of a run's file over HTTP begins so; its name follows.
inline constexpr std::string_view kRunFiles = "/api/v1/runs/";

// GET /api/v1/runs/FILE: the file of a run that was closed, or why it cannot be downloaded. A file that is not in the
// list of runs is never opened.
[[nodiscard]] HttpReply run_file_answer(const ServiceView& view, std::string_view file);

// The recorded run whose dwells the service tells: that which goes on, or until the next one begins, the last. null:
// there is none.
[[nodiscard]] const record::ListedRun* run_of_dwells(const ServiceView& view);

// The run with this file name; nullptr: none is listed. Lives as long as the view.
[[nodiscard]] const record::ListedRun* listed_run(const ServiceView& view, std::string_view file);
// Why the dwells of the run's file are not told; empty: they are. A run without dwells is no obstacle.
[[nodiscard]] std::string no_dwells(const ServiceView& view, const record::ListedRun& run);

// GET /api/v1/runs.
[[nodiscard]] HttpReply runs_answer(const ServiceView& view, std::string_view query);

}  // namespace dwell
