#include "daemon/serve/rights.hpp"

#include <string>
#include <utility>

#include "daemon/serve/host_check.hpp"
#include "daemon/serve/operator_verbs.hpp"

namespace dwell {
namespace {

constexpr const char* kHow =
    "send it as \"Authorization: Bearer TOKEN\", or log in on the page; it stands in the file that [server] token_file "
    "of the rig file names";
constexpr const char* kNoToken =
    "nothing can be changed over HTTP, for the rig file names no [server] token_file; dwellctl on this computer can";

constexpr const char* kDone = R"({"done":true})";
// No script reads the cookie, and no request from another site's page carries it. Not "Secure": browsers send such a
// cookie over TLS only, and the service speaks plain HTTP.
constexpr const char* kCookieRules = "; Path=/; HttpOnly; SameSite=Strict";

config::Mistakes mistake(const config::Position& at, std::string message) {
  return {{at.line, at.column, std::move(message)}};
}

// The text behind "Bearer "; nullopt: the field is missing or of another scheme.
std::optional<std::string_view> bearer(std::string_view authorization) {
  constexpr std::string_view kScheme = "Bearer ";
  if (!same_name(authorization.substr(0, kScheme.size()), kScheme)) return std::nullopt;
  return authorization.substr(kScheme.size());
}

}  // namespace

config::Result<Access> read_access(const config::ServerSettings& server) {
  const bool asked = !config::beyond_loopback(server.listen.host) || server.behind_proxy;
  Access access;
  access.open = asked;
  access.cookie += "_" + std::to_string(server.listen.port);
  if (server.token_file.empty()) {
    if (asked) return access;
    return tl::unexpected(
        mistake(server.listen_at, "\"listen\" is " + config::in_quotes(server.listen.text) +
                                      ", which other computers reach, and nothing says who may read there: expected a "
                                      "token_file, or behind_proxy = true where a proxy asks who it is, or 127.0.0.1"));
  }
  auto token = Token::read(server.token_file);
  if (!token)
    return tl::unexpected(
        mistake(server.token_file_at, "token_file " + config::in_quotes(server.token_file) + " " + token.error()));
  access.token = std::move(*token);
  return access;
}

config::Result<void> check_modbus_access(const config::ModbusServerSettings& server) {
  if (server.open_to_network || !config::beyond_loopback(server.listen.host)) return {};
  return tl::unexpected(
      mistake(server.listen_at, "\"listen\" is " + config::in_quotes(server.listen.text) +
                                    ", which other computers reach, and Modbus asks nobody who it is: expected "
                                    "open_to_network = true, where all who reach it may read, or 127.0.0.1"));
}

bool Rights::renew(Access access) {
  const bool other = access.token != access_.token || access.open != access_.open;
  access_ = std::move(access);
  if (other) sessions_.end_all();
  return other;
}

bool Rights::known(const HttpRequest& request) {
  if (!access_.token) return false;
  const auto given = bearer(request.authorization);
  if (!given) return sessions_.use(cookie_value(request.cookie, access_.cookie), clock_());
  if (access_.token->is(*given)) return true;
  failed(request);
  return false;
}

bool Rights::may_read(const HttpRequest& request) { return access_.open || request.from_loopback || known(request); }

void Rights::failed(const HttpRequest& request) {
  ++failures_;
  const auto many = lines_.admit(clock_());
  if (!many) return;
  const std::string from(request.from);
  log_.warning(*many == 1 ? "a wrong token from " + from
                          : std::to_string(*many) + " wrong tokens, the newest from " + from);
}

std::optional<HttpReply> Rights::reading_refused(const HttpRequest& request) {
  if (may_read(request)) return std::nullopt;
  return http_error(401, std::string("to read from another computer needs the token: ") + kHow);
}

std::optional<HttpReply> Rights::changing_refused(const HttpRequest& request) {
  if (!access_.token) return http_error(403, kNoToken);
  if (known(request)) return std::nullopt;
  return http_error(401, std::string("to change something needs the token: ") + kHow);
}

HttpReply Rights::login(const HttpRequest& request) {
  if (!access_.token) return http_error(403, kNoToken);
  const auto body = parse_request(request.body);
  const auto* given = body && body->contains("token") ? (*body)["token"].get_ptr<const std::string*>() : nullptr;
  if (given == nullptr) return http_error(400, R"(the body cannot be used: expected {"token": TEXT})");
  if (!access_.token->is(*given)) {
    failed(request);
    return http_error(401,
                      "this is not the token; it stands in the file that the rig file names as [server] token_file");
  }
  HttpReply reply{200, kDone};
  reply.cookie = access_.cookie + "=" + sessions_.begin(clock_()) + kCookieRules;
  return reply;
}

HttpReply Rights::logout(const HttpRequest& request) {
  sessions_.end(cookie_value(request.cookie, access_.cookie));
  HttpReply reply{200, kDone};
  reply.cookie = access_.cookie + "=" + kCookieRules + "; Max-Age=0";
  return reply;
}

std::string Rights::session_of(const HttpRequest& request) {
  const std::string_view value = cookie_value(request.cookie, access_.cookie);
  return sessions_.use(value, clock_()) ? std::string(value) : std::string();
}

HttpReply Rights::told(const HttpRequest& request) {
  const bool change = known(request);
  const bool read = change || access_.open || request.from_loopback;
  const auto word = [](bool yes) { return yes ? "true" : "false"; };
  return {200, std::string("{\"read\":") + word(read) + ",\"change\":" + word(change) +
                   ",\"token\":" + word(access_.token.has_value()) + "}"};
}

}  // namespace dwell
