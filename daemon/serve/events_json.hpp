// GET /api/v1/events. Pure.
#pragma once

#include <cstddef>
#include <string_view>

#include "daemon/serve/http_server.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

// Events in one answer at most, and unless ?count= asks for fewer: 20 kB.
inline constexpr std::size_t kEventsPerAnswer = 200;

[[nodiscard]] HttpReply events_answer(const ServiceView& view, std::string_view query);

}  // namespace dwell
