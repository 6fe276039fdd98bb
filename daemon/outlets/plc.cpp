#include "daemon/outlets/plc.hpp"

#include <utility>

namespace dwell {

tl::expected<std::unique_ptr<Plc>, ListenFailure> Plc::make(EventLoop& loop, const ModbusOptions& options) {
  std::unique_ptr<Plc> made(new Plc);
  auto server = ModbusServer::make(loop, options, [plc = made.get()](std::uint16_t first, std::uint16_t count) {
    return plc->image_.read(first, count);
  });
  if (!server) return tl::unexpected(std::move(server.error()));
  made->server_ = std::move(*server);
  return made;
}

}  // namespace dwell
