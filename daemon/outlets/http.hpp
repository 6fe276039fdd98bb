// The service over HTTP: answers, and the live stream that is pushed the dwell as it stands.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <tl/expected.hpp>

#include "daemon/outlets/dwell_stream.hpp"
#include "daemon/outlets/outlet.hpp"
#include "daemon/serve/http_server.hpp"
#include "daemon/serve/page_files.hpp"

namespace dwell {

class Http final : public Outlet {
 public:
  using Now = std::function<ServiceView()>;

  // Binds and listens. now: how the service stands, asked for each answer. page: served beside it.
  static tl::expected<std::unique_ptr<Http>, HttpServer::Failure> make(EventLoop& loop, const HttpOptions& options,
                                                                       Now now, PageFiles page = PageFiles());

  void show(const ServiceView& now) override;
  void tell(const RunEvent& /*event*/, const Rig& /*rig*/) override {}

  [[nodiscard]] const HttpServer& server() const noexcept { return *server_; }

 private:
  Http() = default;

  DwellStream stream_;
  std::uint64_t told_sequence_ = 0;  // the newest snapshot that was pushed
  std::unique_ptr<HttpServer> server_;
};

}  // namespace dwell
