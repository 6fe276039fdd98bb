#include "drivers/modbus/serial_lock.hpp"

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace dwell::modbus {
namespace {

// Programs that ask for no lock are kept away by the kernel, all but the superuser's.
TEST(SerialLock, ExcludesProgramsThatDoNotAskForIt) {
  int host = -1, line = -1;
  char name[64] = {};
  ASSERT_EQ(openpty(&host, &line, name, nullptr, nullptr), 0);
  const auto is_exclusive = [&] {
    int exclusive = 0;
    EXPECT_EQ(ioctl(line, TIOCGEXCL, &exclusive), 0);
    return exclusive != 0;
  };
  SerialLock lock;
  ASSERT_EQ(lock.take(name), "");
  EXPECT_FALSE(is_exclusive());
  lock.exclude_others();
  EXPECT_TRUE(is_exclusive());
  SerialLock other;
  EXPECT_NE(other.take(name), "");
  lock.release();
  EXPECT_FALSE(is_exclusive());
  close(line);
  close(host);
}

}  // namespace
}  // namespace dwell::modbus
