// The service's one event loop: HTTP, control socket, signals, watchdog and the wake-ups of the estimation thread all
// run on the thread that calls run(). Everything is bound to that thread but stop() and post().
#pragma once

#include <chrono>
#include <functional>
#include <memory>

namespace boost::asio {
class io_context;
}

namespace dwell {

class EventLoop {
 public:
  EventLoop();
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  // Calls `ready` whenever `descriptor` (not owned; it must stay open until the loop ends) can be read. `ready` must
  // read it empty.
  void on_readable(int descriptor, std::function<void()> ready);

  // Calls `due` every `period`, the first time after one.
  void every(std::chrono::milliseconds period, std::function<void()> due);

  // Runs until stop(). What a handler throws is handed to `failed` and the loop goes on: one request that fails must
  // not end the service.
  void run(const std::function<void(const char*)>& failed);

  // Thread-safe.
  void stop();
  void post(std::function<void()> work);

  // For those who speak Asio.
  [[nodiscard]] boost::asio::io_context& context() noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell
