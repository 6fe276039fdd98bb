// What can be said of real lines where there is no chip; with one, ./dev vm-test does.
#include "daemon/gpio/kernel_lines.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>

namespace dwell::gpio {
namespace {

config::GpioLine on(const char* chip) {
  config::GpioLine line;
  line.chip = chip;
  line.line = 3;
  return line;
}

TEST(KernelLines, AnAbsentChipIsSaidToBe) {
  KernelLines lines;
  const auto input = lines.input(on("/dev/no-such-gpiochip"), Edges::both);
  ASSERT_FALSE(input);
  EXPECT_EQ(input.error(), "there is no /dev/no-such-gpiochip");
  EXPECT_FALSE(lines.output(on("/dev/no-such-gpiochip"), false));
}

TEST(KernelLines, AFileThatIsNoChipIsSaidToBeNone) {
  KernelLines lines;
  for (const char* file : {"/dev/null", "/etc/passwd"}) {
    const auto input = lines.input(on(file), Edges::rising);
    ASSERT_FALSE(input);
    EXPECT_NE(input.error().find("no GPIO chip"), std::string::npos) << input.error();
  }
}

TEST(KernelLines, ALineInUseIsToldWithItsHolder) {
  EXPECT_EQ(line_fault(on("/dev/gpiochip0"), EBUSY, "kernel-led"),
            "line 3 of /dev/gpiochip0 is in use by \"kernel-led\"");
  EXPECT_EQ(line_fault(on("/dev/gpiochip0"), EBUSY, ""), "line 3 of /dev/gpiochip0 is in use");
}

TEST(KernelLines, AChipThatGoesWakesAsAnErrorNotAsAnEdge) {
  int ends[2];
  ASSERT_EQ(pipe2(ends, O_CLOEXEC), 0);
  EXPECT_EQ(edges_wait(ends[0]).value(), false);
  ASSERT_EQ(write(ends[1], "x", 1), 1);
  EXPECT_EQ(edges_wait(ends[0]).value(), true);
  char byte = 0;
  ASSERT_EQ(read(ends[0], &byte, 1), 1);
  close(ends[1]);
  EXPECT_FALSE(edges_wait(ends[0]));
  close(ends[0]);
}

}  // namespace
}  // namespace dwell::gpio
