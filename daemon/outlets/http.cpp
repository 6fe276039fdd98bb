#include "daemon/outlets/http.hpp"

#include <utility>

#include "daemon/serve/api.hpp"

namespace dwell {

tl::expected<std::unique_ptr<Http>, HttpServer::Failure> Http::make(EventLoop& loop, const HttpOptions& options,
                                                                    Now now, PageFiles page) {
  std::unique_ptr<Http> made(new Http);
  auto server = HttpServer::make(
      loop, options,
      [now, page = std::move(page)](std::string_view path, std::string_view query) {
        if (auto file = page.answer(path)) return std::move(*file);
        return http_answer(now(), path, query);
      },
      [now, stream = &made->stream_] {
        stream->joined();
        return event_text("dwell", dwell_text_json(now()));
      });
  if (!server) return tl::unexpected(std::move(server.error()));
  made->server_ = std::move(*server);
  return made;
}

void Http::show(const ServiceView& now) {
  // Shown again without a newer snapshot: that was pushed already.
  if (std::exchange(told_sequence_, now.snapshot.sequence) == now.snapshot.sequence || now.http.streams == 0) return;
  const DwellStream::Event event = stream_.next(live_dwell(now), now.snapshot.t_ns);
  server_->broadcast(event.name, event.data);
}

}  // namespace dwell
