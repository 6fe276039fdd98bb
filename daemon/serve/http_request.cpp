#include "daemon/serve/http_request.hpp"

#include <utility>

#include "daemon/serve/host_check.hpp"
#include "daemon/serve/http_actions.hpp"

namespace dwell {
namespace {

// Whether the end of the body is certain (RFC 9112, 6.3): by its Content-Length, or by the chunks of HTTP/1.1. With an
// uncertain end a part of the body could be taken for the next request.
bool has_certain_end(const HttpRequest& request) {
  return request.codings == 0 ||
         (request.host_needed && request.codings == 1 && !request.has_length && same_name(request.coding, "chunked"));
}

}  // namespace

std::optional<HttpRefusal> refusal(const HttpRequest& request, const std::vector<std::string>& names) {
  if (!has_certain_end(request))
    return HttpRefusal{http_error(400,
                                  "the end of the body is not certain: expected a Content-Length, or in HTTP/1.1 "
                                  "\"Transfer-Encoding: chunked\" alone")};
  if (request.hosts > 1 || (request.hosts == 0 && request.host_needed))
    return HttpRefusal{http_error(400, "expected one Host field")};
  if (request.hosts == 1 && !is_our_host(request.host, names))
    return HttpRefusal{http_error(421, "\"" + std::string(request.host) +
                                           "\" is no name of this service: expected a numeric address, localhost or "
                                           "one of [server] names in the rig file")};
  if (request.method == HttpRequest::Method::other)
    return HttpRefusal{method_refusal(posted_verb(request.path()) ? "POST" : "GET, HEAD",
                                      "only GET and HEAD, and POST where something can be changed")};
  if (request.target.empty() || request.target.front() != '/')
    return HttpRefusal{http_error(400, "the target is no path"), false};
  return std::nullopt;
}

HttpReply method_refusal(std::string allowed, std::string_view reason) {
  HttpReply reply = http_error(405, reason);
  reply.allowed = std::move(allowed);
  return reply;
}

HttpReply unless_known(HttpReply reply, const HttpRequest& request) {
  // A tag has quotes at its ends and nowhere else: a match within the field is a match of a whole tag.
  if (reply.tag.empty() || request.known.find(reply.tag) == std::string_view::npos) return reply;
  reply.status = 304;
  reply.body.clear();
  return reply;
}

}  // namespace dwell
