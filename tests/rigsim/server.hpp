// A simulated rig, served: Modbus TCP and RTU, from a thread of its own. Usable in-process by tests, and by the
// program.
//
// Of one request every register is read at one instant (unless --sample or --refresh say otherwise): the middle of the
// device's turnaround, that is (for RTU: after the request's wire time) latency/2 after the request's arrival.
// Simulated time is the host's CLOCK_MONOTONIC_RAW since the start times 1 + clock drift. On a pseudo-terminal bytes
// take no time, so the wire time of request and answer (at the speed the client has set) is waited for. Each
// connection's requests are answered in order, one at a time; only late answers come out of turn.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "tests/rigsim/options.hpp"

namespace rigsim {

class Server {
 public:
  // Starts serving, or says why not (an address in use, a chain that is none).
  [[nodiscard]] static tl::expected<std::unique_ptr<Server>, std::string> start(Options options);
  ~Server();  // stops; removes what it made in the file system
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  // All of these may be called from any thread.
  [[nodiscard]] std::uint16_t tcp_port() const;  // 0: no TCP
  [[nodiscard]] std::string rtu_path() const;    // the link, or else the pseudo-terminal itself; empty: no RTU
  // Executes a control line between two requests: "ok", "ok …" or "error: …".
  std::string command(const std::string& line);
  // The simulated time (s) at an instant of the host's clock.
  [[nodiscard]] double simulated_time_s(std::int64_t clock_ns) const;

 private:
  struct Impl;
  explicit Server(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace rigsim
