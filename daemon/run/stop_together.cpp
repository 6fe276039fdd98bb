#include "daemon/run/stop_together.hpp"

#include <future>
#include <system_error>
#include <thread>
#include <utility>

namespace dwell {

std::vector<std::string> stop_together(std::vector<std::shared_ptr<DeviceHost>> devices,
                                       std::chrono::milliseconds within) {
  struct Stopping {
    DeviceLink& link;
    std::future<void> stopped;
    std::thread thread;  // shares the device: the last of them destroys it
  };
  const auto until = std::chrono::steady_clock::now() + within;
  std::vector<Stopping> all;
  all.reserve(devices.size());
  for (std::shared_ptr<DeviceHost>& device : devices) {
    DeviceLink& link = device->link();
    std::packaged_task<void()> stop([device] { device->stop(); });
    auto stopped = stop.get_future();
    try {
      all.push_back({link, std::move(stopped), std::thread(std::move(stop))});
      device.reset();
    } catch (const std::system_error&) {
      device->stop();  // no thread can be begun: the others wait for this one
    }
  }
  std::vector<std::string> left_behind;
  for (Stopping& one : all) {
    if (one.stopped.wait_until(until) == std::future_status::ready) {
      one.thread.join();
      continue;
    }
    left_behind.push_back(one.link.name());
    one.link.abandon();
    one.thread.detach();
  }
  return left_behind;
}

}  // namespace dwell
