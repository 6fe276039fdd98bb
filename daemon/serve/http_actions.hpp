// What can be changed over HTTP: a POST of one JSON object to the path of a verb. Pure. Rights decides who may.
#pragma once

#include <optional>
#include <string_view>

#include "daemon/serve/http_request.hpp"
#include "daemon/serve/operator_verbs.hpp"

namespace dwell {

// The verb that a POST of this path asks for: "start" of "/api/v1/start". nullopt: nothing can be changed there.
[[nodiscard]] std::optional<std::string_view> posted_verb(std::string_view path);

// Refuses what a page of another site can make a visitor's browser send (CSRF): an Origin that is not the Host, and a
// body that a form could have sent.
[[nodiscard]] std::optional<HttpReply> foreign_refusal(const HttpRequest& request);

// Does it: {"done": true}; 400 where the body cannot be used, 409 where it cannot be done now.
[[nodiscard]] HttpReply action_answer(std::string_view verb, const HttpRequest& request, const Operate& operate);

}  // namespace dwell
