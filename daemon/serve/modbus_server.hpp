// A Modbus TCP server for PLCs, on the event loop. It moves bytes; ModbusConversation understands them, a handler has
// the registers. Limits bound the number of clients, the bytes of a request, the time for a request and for taking an
// answer, and the answers per second. When all places are taken, a new client replaces the one that has been silent
// longest. Clients that never asked for anything go first, then those that have not asked for `kept_time`. Bound to the
// event loop's thread.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "daemon/serve/listen_failure.hpp"
#include "daemon/serve/modbus_conversation.hpp"

namespace dwell {

class EventLoop;

struct ModbusOptions {
  std::string host = "127.0.0.1";  // a numeric address, or "localhost"
  std::uint16_t port = 0;          // 0: the kernel chooses
  // Connections at once: a PLC, an operator panel and a historian, each with a spare, and room for more. Each costs a
  // descriptor; because of libmodbus the service has 1024 of these.
  std::size_t clients = 16;
  // For a request, from its first byte to its last; the same again for taking the answer.
  std::chrono::milliseconds request_time{2'000};
  // A connection without a request is closed after so long. A PLC that polls more seldom connects anew each time.
  std::chrono::milliseconds idle_time{300'000};
  // A client that was answered keeps its place for so long. Shorter: where somebody opens many connections, PLCs that
  // poll slowly lose their places. Longer: for so long, clients that ask once can keep others out.
  std::chrono::milliseconds kept_time{10'000};
  // Between an answer and the client's next request: 500 answers a second at most. Shorter: a client that asks without
  // end takes more of the event loop's time. Longer: a rig of 64 masses is read in 7 requests, which should all
  // fall between two images.
  std::chrono::milliseconds pause{2};
};

struct ModbusStats {
  std::uint64_t clients = 0;     // now
  std::uint64_t answers = 0;     // requests that were answered with registers
  std::uint64_t exceptions = 0;  // requests that were answered with an exception
  std::uint64_t malformed = 0;   // connections closed because their bytes were not Modbus TCP
  // Connections closed because no request came, only a part of one came, or an answer was not taken.
  std::uint64_t timed_out = 0;
  std::uint64_t refused = 0;    // connections, because there were too many
  std::uint64_t displaced = 0;  // silent connections that made room for new ones
  bool awaits_address = false;  // this computer does not have the address yet: nobody can be served
};

class ModbusServer {
 public:
  // Binds and listens. An address that this computer does not have yet is served once it has it.
  static tl::expected<std::unique_ptr<ModbusServer>, ListenFailure> make(EventLoop& loop, const ModbusOptions& options,
                                                                         ReadRegisters read);
  ~ModbusServer();  // closes every connection
  ModbusServer(const ModbusServer&) = delete;
  ModbusServer& operator=(const ModbusServer&) = delete;

  [[nodiscard]] std::uint16_t port() const;
  [[nodiscard]] ModbusStats stats() const noexcept;

  struct Impl;  // defined where Asio is

 private:
  explicit ModbusServer(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace dwell
