// dwelld in one object: the log, the event loop with HTTP and control socket, the watchdog, and the session of one rig.
#pragma once

#include <signal.h>

#include <cstdint>
#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "config/rig_file.hpp"
#include "daemon/log/log.hpp"
#include "daemon/run/awaited_starts.hpp"

namespace dwell {

struct ServiceOptions {
  std::string control_path;    // empty: no control socket
  std::string page_folder{};   // of the page's files; empty: no page
  bool handle_signals = true;  // those of service_signals(), which must be blocked in every thread
  std::int64_t start_patience_ns = AwaitedStarts::kPatience_ns;  // the longest wait of an answer to `start`
};

// SIGTERM and SIGINT end run(). SIGHUP checks the rig file as it stands now and says in the log what it found.
[[nodiscard]] sigset_t service_signals();

class Service {
 public:
  struct Failure {
    int exit_code = 1;  // 2: what was asked for cannot be; 1: it cannot be had now
    std::string message;
  };

  // Binds and listens, makes the session and starts its threads; devices are not awaited. The log outlives it.
  static tl::expected<std::unique_ptr<Service>, Failure> make(config::RigFile file, const config::SchemaSource& drivers,
                                                              const ServiceOptions& options, Log& log);
  ~Service();
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  // Tells systemd that it is ready and serves until a signal or stop().
  void run();
  // Thread-safe.
  void stop();

  [[nodiscard]] std::uint16_t port() const;

 private:
  struct Impl;
  explicit Service(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell
