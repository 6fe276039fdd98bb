#include "daemon/outlets/http.hpp"

#include <string>
#include <utility>
#include <vector>

#include "daemon/serve/api.hpp"
#include "daemon/serve/element_standing.hpp"
#include "daemon/serve/gzip.hpp"
#include "daemon/serve/http_actions.hpp"
#include "daemon/serve/operator_verbs.hpp"
#include "daemon/serve/query.hpp"

namespace dwell {
namespace {

// The operator who is known by the token alone.
record::Person bearer_at(std::string_view address) {
  return {std::nullopt, "http:" + std::string(address) + " by token"};
}

std::optional<HttpReply> query_refused(const HttpRequest& request, const std::vector<QueryKey>& keys = {}) {
  const auto fault = query_fault(request.query(), keys);
  return fault ? std::optional(http_error(400, *fault)) : std::nullopt;
}

}  // namespace

tl::expected<std::unique_ptr<Http>, ListenFailure> Http::make(EventLoop& loop, const HttpOptions& options,
                                                              HttpContent content) {
  std::unique_ptr<Http> made(new Http(std::move(content)));
  auto server = HttpServer::make(
      loop, options, [http = made.get()](const HttpRequest& request) { return http->answer(request); },
      [http = made.get()](const HttpRequest& request) { return http->begin_stream(request); });
  if (!server) return tl::unexpected(std::move(server.error()));
  made->server_ = std::move(*server);
  return made;
}

std::optional<HttpReply> Http::reading_refused(const HttpRequest& request) const {
  return content_.rights == nullptr ? std::nullopt : content_.rights->reading_refused(request);
}

tl::expected<StreamBegin, HttpReply> Http::begin_stream(const HttpRequest& request) {
  if (auto refused = reading_refused(request)) return tl::unexpected(std::move(*refused));
  const QueryKey traces{"traces", "traces", [](std::string_view value) { return value.empty(); }};
  if (auto refused = query_refused(request, {traces})) return tl::unexpected(std::move(*refused));
  stream_.joined();
  return StreamBegin{event_text("dwell", dwell_text_json(content_.now())),
                     content_.rights == nullptr ? std::string() : content_.rights->session_of(request)};
}

void Http::end_streams_of_ended_sessions() const {
  if (content_.rights == nullptr) return;
  for (const std::string& session : content_.rights->take_ended_sessions()) server_->end_streams(session);
}

HttpReply Http::answer(const HttpRequest& request) const {
  const auto verb = posted_verb(request.path());
  if (request.method == HttpRequest::Method::post) {
    if (verb) return act(*verb, request);
    return method_refusal("GET, HEAD", "only GET and HEAD: nothing can be changed here");
  }
  if (verb) return method_refusal("POST", "only POST: this path changes something");
  // The page reads the query of its address itself.
  if (auto file = content_.page.answer(request.path(), accepts_gzip(request.encodings))) return std::move(*file);
  if (request.path() == "/api/v1/rights" && content_.rights != nullptr) {
    if (auto refused = query_refused(request)) return std::move(*refused);
    return content_.rights->told(request);
  }
  if (auto refused = reading_refused(request)) return std::move(*refused);
  if (RunDwells::is_asked(request.path())) return run_dwells_.answer(content_.now(), request.path(), request.query());
  return http_answer(content_.now(), request.path(), request.query());
}

HttpReply Http::act(std::string_view verb, const HttpRequest& request) const {
  if (auto foreign = foreign_refusal(request)) return std::move(*foreign);
  if (auto refused = query_refused(request)) return std::move(*refused);
  if (content_.rights == nullptr) return http_error(403, "nothing can be changed over HTTP");
  if (verb == "login" || verb == "logout") {
    HttpReply reply = verb == "login" ? content_.rights->login(request) : content_.rights->logout(request);
    end_streams_of_ended_sessions();
    return reply;
  }
  if (auto refused = content_.rights->changing_refused(request)) return std::move(*refused);
  HttpReply reply = action_answer(
      verb, request, [&](const OperatorRequest& asked) { return content_.operate(asked, bearer_at(request.from)); });
  if (verb == "start" && reply.status == 200 && content_.await_start)
    reply.awaited = [this](const HttpReply::Tell& tell) {
      content_.await_start([tell](const StartOutcome& outcome) {
        auto known = start_answer(outcome);
        tell(known ? HttpReply{200, std::move(*known)} : http_error(409, known.error()));
      });
    };
  return reply;
}

void Http::show(const ServiceView& now) {
  end_streams_of_ended_sessions();
  // Shown again without a newer snapshot: that was pushed already. Once it is stale, that and its age are news.
  const bool told = std::exchange(told_sequence_, now.snapshot.sequence) == now.snapshot.sequence;
  if ((told && !is_stale(now)) || now.clients.http.streams == 0) return;
  const DwellStream::Event event = stream_.next(live_dwell(now), told ? now.now_ns : now.snapshot.t_ns);
  server_->broadcast(event.name, event.data);
}

}  // namespace dwell
