// What operators may ask for, as JSON: the same members over HTTP and over the control socket. Pure.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "daemon/report/dwell_json_value.hpp"
#include "daemon/run/awaited_starts.hpp"
#include "daemon/run/operator_requests.hpp"

namespace dwell {

// Does an operator's request, or fails with the reason.
using Operate = std::function<tl::expected<void, std::string>(const OperatorRequest&)>;

// Why a request was not done.
struct NotDone {
  enum class Kind : std::uint8_t { unusable, impossible_now };
  Kind kind;
  std::string reason;
};

// The request's JSON object; fails with what is wrong. Refuses deep nesting, since the parser recurses and a line may
// hold 64 KiB of brackets.
[[nodiscard]] tl::expected<Json, std::string> parse_request(std::string_view text);

[[nodiscard]] bool is_operator_verb(std::string_view verb);
// Does what the verb and the other members of the object ask for.
[[nodiscard]] tl::expected<void, NotDone> perform(std::string_view verb, const Json& request, const Operate& operate);
// The JSON that answers `start`, or why its run is not recorded.
[[nodiscard]] tl::expected<std::string, std::string> start_answer(const StartOutcome& outcome);

}  // namespace dwell
