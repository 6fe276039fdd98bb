// What the service says over HTTP and over the control socket, made from the newest snapshot. Pure: no I/O, no clock.
// A number that does not exist is null. Bound to one thread; throws only where memory ends.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "daemon/serve/http_server.hpp"
#include "daemon/serve/operator_verbs.hpp"
#include "daemon/service_view.hpp"

namespace dwell {

// Finished dwells in one answer of /api/v1/dwells at most, and unless ?count= asks for fewer …
inline constexpr std::size_t kDwellsPerAnswer = 100;
// … and at most so many bytes of them, but always one. Larger: 128 clients that ask at once and read slowly hold more
// memory; smaller: more requests for many large dwells (of 30 elements one has 0.4 to 0.6 MB).
inline constexpr std::size_t kBytesOfDwells = 4'000'000;

// Runs in one answer of /api/v1/runs, unless ?count= asks for fewer: 60 kB.
inline constexpr std::size_t kRunsPerAnswer = 100;

// GET `path`.
[[nodiscard]] HttpReply http_answer(const ServiceView& view, std::string_view path, std::string_view query);

// One line of the control socket.
[[nodiscard]] std::string control_answer(const ServiceView& view, std::string_view line, const Operate& operate);

// The dwell object of the snapshot, one line.
[[nodiscard]] std::string dwell_text_json(const ServiceView& view);

}  // namespace dwell
