#include "daemon/serve/http_actions.hpp"

#include <array>
#include <utility>

#include "daemon/serve/host_check.hpp"

namespace dwell {
namespace {

constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kActions{{
    {"/api/v1/start", "start"},
    {"/api/v1/stop", "stop"},
    {"/api/v1/label", "label"},
    {"/api/v1/rearm", "rearm"},
    {"/api/v1/login", "login"},
    {"/api/v1/logout", "logout"},
    {"/api/v1/alarms/acknowledge", "acknowledge"},
}};

}  // namespace

std::optional<std::string_view> posted_verb(std::string_view path) {
  for (const auto& [known, verb] : kActions)
    if (known == path) return verb;
  return std::nullopt;
}

std::optional<HttpReply> foreign_refusal(const HttpRequest& request) {
  // A browser states the origin of every POST; a program states none. Behind a proxy that ends TLS the schemes differ.
  const std::size_t slashes = request.origin.find("://");
  const bool own = slashes != std::string_view::npos && same_name(request.origin.substr(slashes + 3), request.host);
  if (!request.origin.empty() && !own)
    return http_error(403, "a page of " + std::string(request.origin) +
                               " may change nothing here: expected the page of this service, or no Origin");
  std::string_view type = request.content_type.substr(0, request.content_type.find(';'));
  while (!type.empty() && (type.back() == ' ' || type.back() == '\t')) type.remove_suffix(1);
  if (!same_name(type, "application/json"))
    return http_error(415, "expected a body of Content-Type: application/json, not \"" + std::string(type) + "\"");
  return std::nullopt;
}

HttpReply action_answer(std::string_view verb, const HttpRequest& request, const Operate& operate) {
  const auto body = parse_request(request.body);
  if (!body) return http_error(400, "the body cannot be used: " + body.error());
  const auto done = perform(verb, *body, operate);
  if (!done) return http_error(done.error().kind == NotDone::Kind::unusable ? 400 : 409, done.error().reason);
  return {200, R"({"done":true})"};
}

}  // namespace dwell
