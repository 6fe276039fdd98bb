#include "daemon/gpio/kernel_lines.hpp"

#include <poll.h>

#include <cerrno>
#include <system_error>

namespace dwell::gpio {

std::string line_fault(const config::GpioLine& line, int error, const std::string& holder) {
  const std::string which = "line " + std::to_string(line.line) + " of " + line.chip;
  switch (error) {
    case ENOENT:
      return "there is no " + line.chip;
    case ENOTTY:
    case ENOTDIR:
    case EISDIR:
      return line.chip + " is no GPIO chip";
    case ENODEV:
      return line.chip + " has gone, or is no GPIO chip";
    case EACCES:
    case EPERM:
      return line.chip + " may not be opened: is the service's user in the group of that file?";
    case EINVAL:
      return "there is no " + which + ", or it cannot do what is asked of it";
    case EBUSY:
      return which + " is in use" + (holder.empty() ? "" : " by \"" + holder + "\"");
    case ENXIO:
      return which + " tells no edges: its chip has no interrupts";
    default:
      return which + ": " + std::system_category().message(error);
  }
}

tl::expected<bool, std::string> edges_wait(int descriptor) {
  pollfd polled{descriptor, POLLIN, 0};
  if (poll(&polled, 1, 0) < 0) return false;
  if ((polled.revents & POLLIN) != 0) return true;
  if (polled.revents != 0) return tl::unexpected(std::string("the chip has gone"));
  return false;
}

}  // namespace dwell::gpio
