// The recorder in the service's answers: the object in the health, and the list of runs. Pure, as api.hpp. Heavy:
// include it in .cpp only.
#pragma once

#include <string_view>

#include "daemon/report/dwell_json_value.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

// The recorder's state; null if the service has none.
[[nodiscard]] Json recorder_json(const ServiceView& view);

// GET /api/v1/runs.
[[nodiscard]] HttpReply runs_answer(const ServiceView& view, std::string_view query);

}  // namespace dwell
