// What the service says of its recorder: the object in the health, and the list of runs. Pure, as api.hpp.
#pragma once

#include <cstddef>
#include <string_view>

#include "daemon/report/dwell_json_value.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

// Runs in one answer of /api/v1/runs at most, and unless ?count= asks for fewer: 60 kB.
inline constexpr std::size_t kRunsPerAnswer = 100;

// How the recorder stands; null where the service has none.
[[nodiscard]] Json recorder_json(const ServiceView& view);

// GET /api/v1/runs.
[[nodiscard]] HttpReply runs_answer(const ServiceView& view, std::string_view query);

}  // namespace dwell
