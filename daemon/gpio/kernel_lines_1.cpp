// libgpiod 1.6.
#include <gpiod.h>

#include <algorithm>
#include <array>
#include <cerrno>

#include "daemon/gpio/kernel_lines.hpp"

namespace dwell::gpio {
namespace {

struct CloseChip {
  void operator()(gpiod_chip* chip) const noexcept { gpiod_chip_close(chip); }
};
struct ReleaseLine {
  void operator()(gpiod_line* line) const noexcept { gpiod_line_release(line); }
};

// A line on a chip of its own handle; released before that is closed.
struct Held {
  config::GpioLine settings;
  std::unique_ptr<gpiod_chip, CloseChip> chip;
  std::unique_ptr<gpiod_line, ReleaseLine> line;
  [[nodiscard]] std::string fault() const { return line_fault(settings, errno, {}); }
};

int flags_of(const config::GpioLine& line) {
  using Bias = config::GpioLine::Bias;
  int flags = line.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  if (line.bias == Bias::disabled) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
  if (line.bias == Bias::pull_up) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
  if (line.bias == Bias::pull_down) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  return flags;
}

tl::expected<Held, std::string> hold(const config::GpioLine& settings, int request_type, int level) {
  Held held{settings, std::unique_ptr<gpiod_chip, CloseChip>(gpiod_chip_open(settings.chip.c_str())), nullptr};
  if (!held.chip) return tl::unexpected(line_fault(settings, errno, {}));
  gpiod_line* const line = gpiod_chip_get_line(held.chip.get(), settings.line);
  if (line == nullptr) return tl::unexpected(line_fault(settings, errno, {}));
  const gpiod_line_request_config request{kConsumer, request_type, flags_of(settings)};
  if (gpiod_line_request(line, &request, level) != 0) {
    const int error = errno;
    const char* const holder = gpiod_line_consumer(line);
    return tl::unexpected(line_fault(settings, error, holder == nullptr ? "" : holder));
  }
  held.line.reset(line);
  return held;
}

class Input : public InputLine {
 public:
  explicit Input(Held held) : held_(std::move(held)), descriptor_(gpiod_line_event_get_fd(held_.line.get())) {}

  [[nodiscard]] int descriptor() const noexcept override { return descriptor_; }

  tl::expected<bool, std::string> level() override {
    const int level = gpiod_line_get_value(held_.line.get());
    if (level < 0) return tl::unexpected(held_.fault());
    return level != 0;
  }

  tl::expected<std::size_t, std::string> take(LineEdge* out, std::size_t room) override {
    const auto waiting = edges_wait(descriptor_);
    if (!waiting) return tl::unexpected(waiting.error());
    if (!*waiting) return std::size_t{0};
    std::array<gpiod_line_event, kKernelQueue> events{};
    const int count = gpiod_line_event_read_fd_multiple(descriptor_, events.data(),
                                                        static_cast<unsigned>(std::min(room, events.size())));
    if (count < 0) return tl::unexpected(held_.fault());
    // This interface counts no edges: that some were lost shows by the instants alone.
    std::transform(events.begin(), events.begin() + count, out, [](const gpiod_line_event& event) {
      return LineEdge{std::int64_t{event.ts.tv_sec} * 1'000'000'000 + event.ts.tv_nsec,
                      event.event_type == GPIOD_LINE_EVENT_RISING_EDGE, false};
    });
    return static_cast<std::size_t>(count);
  }

 private:
  Held held_;
  int descriptor_;
};

class Output : public OutputLine {
 public:
  explicit Output(Held held) : held_(std::move(held)) {}
  tl::expected<void, std::string> set(bool level) override {
    if (gpiod_line_set_value(held_.line.get(), level ? 1 : 0) != 0) return tl::unexpected(held_.fault());
    return {};
  }

 private:
  Held held_;
};

}  // namespace

tl::expected<std::unique_ptr<InputLine>, std::string> KernelLines::input(const config::GpioLine& line, Edges edges) {
  auto held =
      hold(line, edges == Edges::both ? GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES : GPIOD_LINE_REQUEST_EVENT_RISING_EDGE, 0);
  if (!held) return tl::unexpected(held.error());
  return std::make_unique<Input>(std::move(*held));
}

tl::expected<std::unique_ptr<OutputLine>, std::string> KernelLines::output(const config::GpioLine& line, bool level) {
  auto held = hold(line, GPIOD_LINE_REQUEST_DIRECTION_OUTPUT, level ? 1 : 0);
  if (!held) return tl::unexpected(held.error());
  return std::make_unique<Output>(std::move(*held));
}

}  // namespace dwell::gpio
