// The service over HTTP: answers, what operators ask for, and the live stream that is pushed the dwell as it stands.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>

#include "daemon/outlets/dwell_stream.hpp"
#include "daemon/outlets/live_traces.hpp"
#include "daemon/outlets/outlet.hpp"
#include "daemon/run/awaited_starts.hpp"
#include "daemon/run/operator_requests.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/serve/page_files.hpp"
#include "daemon/serve/rights.hpp"
#include "daemon/serve/run_dwells.hpp"

namespace dwell {

// What is served.
struct HttpContent {
  std::function<ServiceView()> now;  // how the service stands; called for each answer
  PageFiles page{};                  // open to every client: it holds no data
  Rights* rights = nullptr;          // null: everybody may read, nobody may change anything; else must outlive the Http
  // Does what a person asks for, or fails with the reason; may be empty where rights is null.
  std::function<tl::expected<void, std::string>(const OperatorRequest&, const record::Person&)> operate{};
  // Called after a start was done: tells later, once, whether its run is recorded. Empty: nothing is recorded.
  std::function<void(std::function<void(const StartOutcome&)>)> await_start{};
};

class Http final : public Outlet {
 public:
  // Binds and listens.
  static tl::expected<std::unique_ptr<Http>, ListenFailure> make(EventLoop& loop, const HttpOptions& options,
                                                                 HttpContent content);

  void show(const ServiceView& now) override;
  void tell(const RunEvent& /*event*/, const Rig& /*rig*/) override {}

  // Ends every live stream: its client must ask again whether it may read.
  void end_streams() { server_->end_streams(); }
  // Sends the bins completed since the last call; to be called every LiveTraces::kEvery.
  void show_traces(const Traces& traces, std::size_t channels) { live_traces_.push(*server_, traces, channels); }

  [[nodiscard]] const HttpServer& server() const noexcept { return *server_; }

 private:
  explicit Http(HttpContent content) : content_(std::move(content)) {}

  [[nodiscard]] HttpReply answer(const HttpRequest& request) const;
  [[nodiscard]] HttpReply act(std::string_view verb, const HttpRequest& request) const;
  [[nodiscard]] std::optional<HttpReply> reading_refused(const HttpRequest& request) const;
  [[nodiscard]] tl::expected<StreamBegin, HttpReply> begin_stream(const HttpRequest& request);
  // A stream ends with the session that it was begun in.
  void end_streams_of_ended_sessions() const;

  const HttpContent content_;
  DwellStream stream_;
  LiveTraces live_traces_;
  const RunDwells run_dwells_;
  std::uint64_t told_sequence_ = 0;  // the newest snapshot that was pushed
  std::unique_ptr<HttpServer> server_;
};

}  // namespace dwell
