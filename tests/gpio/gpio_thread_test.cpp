#include "daemon/gpio/gpio_thread.hpp"

#include <gtest/gtest.h>

#include <chrono>

#include "daemon/clock.hpp"
#include "tests/gpio/fake_lines.hpp"

namespace dwell::gpio {
namespace {

config::GpioLine line(unsigned number) {
  config::GpioLine line;
  line.chip = "/dev/gpiochip0";
  line.line = number;
  return line;
}

TEST(GpioThread, HandsInTheInterlockBeforeItIsMadeThenTurnsUntilItsEndAndDarkensTheLamps) {
  LogOptions quiet;
  quiet.console = false;
  const auto log = std::move(*Log::make(quiet));
  config::GpioSettings settings;
  settings.interlock = line(0);
  settings.ready = line(2);
  auto lines = std::make_unique<FakeLines>();
  FakeLine& interlock = (*lines)[0];
  FakeLine& ready = (*lines)[2];
  interlock.level = true;
  {
    struct Kept : LineSource {  // the lines outlive the thread, for a look at them afterwards
      explicit Kept(FakeLines& the_lines) : lines(the_lines) {}
      tl::expected<std::unique_ptr<InputLine>, std::string> input(const config::GpioLine& at, Edges edges) override {
        return lines.input(at, edges);
      }
      tl::expected<std::unique_ptr<OutputLine>, std::string> output(const config::GpioLine& at, bool level) override {
        return lines.output(at, level);
      }
      FakeLines& lines;
    };
    GpioThread gpio(settings, std::make_unique<Kept>(*lines), *log);
    const std::int64_t made_ns = raw_now_ns();
    Record first;
    ASSERT_TRUE(gpio.link().pop(first));
    EXPECT_EQ(first.kind, Kind::edge);
    EXPECT_EQ(first.value, 1.0);
    gpio.link().order({true, false}, raw_now_ns());
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    const auto lit = [&] { return gpio.link().status()[static_cast<std::size_t>(Function::ready)].level == true; };
    while ((gpio.last_turn_ns() <= made_ns || gpio.link().seen_to_ns() <= made_ns || !lit()) &&
           std::chrono::steady_clock::now() < end) {
    }
    EXPECT_GT(gpio.last_turn_ns(), made_ns);
    EXPECT_GT(gpio.link().seen_to_ns(), made_ns);
    EXPECT_TRUE(lit());
  }
  EXPECT_FALSE(ready.level);
  EXPECT_FALSE(interlock.held);
}

}  // namespace
}  // namespace dwell::gpio
