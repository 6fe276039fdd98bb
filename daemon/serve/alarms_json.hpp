// GET /api/v1/alarms. Pure.
#pragma once

#include "daemon/serve/http_server.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

[[nodiscard]] HttpReply alarms_answer(const ServiceView& view);

}  // namespace dwell
