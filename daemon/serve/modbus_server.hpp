// A Modbus TCP server for PLCs, on the event loop. It moves bytes; ModbusConversation understands them, a handler has
// the registers. Everything a client can make it spend is bounded: clients, bytes, the time for a request and for
// taking an answer, answers per second. Where there are as many clients as there may be, a new one takes the place of
// the one that has been silent longest: of those that never asked for anything first, then of those that have not asked
// for `kept_time`. Bound to the event loop's thread.
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
  // Connections at once: a PLC, an operator panel, a historian, each with a spare. More of them cost descriptors, of
  // which libmodbus leaves the service 1024 in all.
  std::size_t clients = 16;
  std::chrono::milliseconds request_time{2'000};  // from its first byte until it is here, and for taking the answer
  // Without a request. A PLC that polls more seldom connects anew each time.
  std::chrono::milliseconds idle_time{300'000};
  // A client that was answered keeps its place for so long at least. Shorter: those who poll slowly lose their places
  // where somebody opens many connections; longer: so long such a somebody can keep others out.
  std::chrono::milliseconds kept_time{10'000};
  // From one answer to the client's next request being read: 500 answers a second. Shorter: more of the event loop's
  // time for whoever asks without end. Longer: 64 masses, 7 requests, take longer than an estimate stays the newest.
  std::chrono::milliseconds pause{2};
};

struct ModbusStats {
  std::uint64_t clients = 0;     // now
  std::uint64_t answers = 0;     // requests that were answered with registers
  std::uint64_t exceptions = 0;  // requests that were answered with an exception
  std::uint64_t malformed = 0;   // connections closed because what came was no Modbus TCP
  std::uint64_t timed_out = 0;   // connections closed because half a request came, an answer was not taken, or nothing
  std::uint64_t refused = 0;     // connections, because there were too many
  std::uint64_t displaced = 0;   // silent connections that made room for new ones
  bool awaits_address = false;   // the address is not there yet: nobody can be served
};

class ModbusServer {
 public:
  // Binds and listens; an address that is not there yet is served once it is.
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
