#include "drivers/modbus/serial_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace dwell::modbus {
namespace {

constexpr const char* kTaken =
    "in use by another program; end that, or ask the service that runs (`dwellctl check` without --rig)";

}  // namespace

std::string SerialLock::take(const std::string& port) {
  release();
  descriptor_ = ::open(port.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor_ < 0) return errno == EBUSY ? kTaken : std::generic_category().message(errno);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return {};
  const int error = errno;
  release();
  return error == EWOULDBLOCK ? kTaken : std::generic_category().message(error);
}

void SerialLock::exclude_others() noexcept { ::ioctl(descriptor_, TIOCEXCL); }

void SerialLock::release() noexcept {
  if (descriptor_ < 0) return;
  // A pseudo-terminal would keep it beyond the last close.
  ::ioctl(descriptor_, TIOCNXCL);
  ::close(descriptor_);
  descriptor_ = -1;
}

}  // namespace dwell::modbus
