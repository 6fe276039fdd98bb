// The service for PLCs: a Modbus TCP server that answers from the newest image of the registers (register_map.hpp).
#pragma once

#include <cstdint>
#include <memory>
#include <tl/expected.hpp>

#include "daemon/outlets/outlet.hpp"
#include "daemon/outlets/register_map.hpp"
#include "daemon/serve/modbus_server.hpp"

namespace dwell {

class Plc final : public Outlet {
 public:
  // Binds and listens. Until the first show() there are no registers.
  static tl::expected<std::unique_ptr<Plc>, ListenFailure> make(EventLoop& loop, const ModbusOptions& options);

  // Makes the image that every client reads until the next one. Serving a client only copies registers from it.
  void show(const ServiceView& now) override { image_ = RegisterImage(now, ++generation_); }
  void tell(const RunEvent& /*event*/, const Rig& /*rig*/) override {}

  [[nodiscard]] const ModbusServer& server() const noexcept { return *server_; }

 private:
  Plc() = default;

  RegisterImage image_;
  std::uint16_t generation_ = 0;
  std::unique_ptr<ModbusServer> server_;
};

}  // namespace dwell
