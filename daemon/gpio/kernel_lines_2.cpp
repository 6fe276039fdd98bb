// libgpiod 2.
#include <gpiod.h>

#include <algorithm>
#include <cerrno>

#include "daemon/gpio/kernel_lines.hpp"

namespace dwell::gpio {
namespace {

template <auto release>
struct Release {
  template <class T>
  void operator()(T* object) const noexcept {
    release(object);
  }
};
template <class T, auto release>
using Owned = std::unique_ptr<T, Release<release>>;

using Chip = Owned<gpiod_chip, gpiod_chip_close>;
using Info = Owned<gpiod_line_info, gpiod_line_info_free>;
using Settings = Owned<gpiod_line_settings, gpiod_line_settings_free>;
using LineConfig = Owned<gpiod_line_config, gpiod_line_config_free>;
using RequestConfig = Owned<gpiod_request_config, gpiod_request_config_free>;
using Request = Owned<gpiod_line_request, gpiod_line_request_release>;
using EdgeBuffer = Owned<gpiod_edge_event_buffer, gpiod_edge_event_buffer_free>;

gpiod_line_bias bias_of(const config::GpioLine& line) {
  using Bias = config::GpioLine::Bias;
  switch (line.bias) {
    case Bias::disabled:
      return GPIOD_LINE_BIAS_DISABLED;
    case Bias::pull_up:
      return GPIOD_LINE_BIAS_PULL_UP;
    case Bias::pull_down:
      return GPIOD_LINE_BIAS_PULL_DOWN;
    case Bias::as_is:
      break;
  }
  return GPIOD_LINE_BIAS_AS_IS;
}

std::string holder_of(gpiod_chip* chip, unsigned line) {
  const Info info(gpiod_chip_get_line_info(chip, line));
  const char* const holder = info ? gpiod_line_info_get_consumer(info.get()) : nullptr;
  return holder == nullptr ? "" : holder;
}

// The request keeps the line; the chip's handle is not needed beyond it.
tl::expected<Request, std::string> hold(const config::GpioLine& line, gpiod_line_settings* settings) {
  const Chip chip(gpiod_chip_open(line.chip.c_str()));
  if (!chip) return tl::unexpected(line_fault(line, errno, {}));
  gpiod_line_settings_set_active_low(settings, line.active_low);
  const LineConfig lines(gpiod_line_config_new());
  const RequestConfig request(gpiod_request_config_new());
  if (!lines || !request || gpiod_line_config_add_line_settings(lines.get(), &line.line, 1, settings) != 0)
    return tl::unexpected(line_fault(line, errno, {}));
  gpiod_request_config_set_consumer(request.get(), kConsumer);
  Request held(gpiod_chip_request_lines(chip.get(), request.get(), lines.get()));
  if (!held) {
    const int error = errno;
    return tl::unexpected(line_fault(line, error, holder_of(chip.get(), line.line)));
  }
  return held;
}

class Input : public InputLine {
 public:
  Input(config::GpioLine line, Request request, EdgeBuffer buffer)
      : line_(std::move(line)), request_(std::move(request)), buffer_(std::move(buffer)) {}

  [[nodiscard]] int descriptor() const noexcept override { return gpiod_line_request_get_fd(request_.get()); }

  tl::expected<bool, std::string> level() override {
    const gpiod_line_value level = gpiod_line_request_get_value(request_.get(), line_.line);
    if (level == GPIOD_LINE_VALUE_ERROR) return tl::unexpected(line_fault(line_, errno, {}));
    return level == GPIOD_LINE_VALUE_ACTIVE;
  }

  tl::expected<std::size_t, std::string> take(LineEdge* out, std::size_t room) override {
    const auto waiting = edges_wait(descriptor());
    if (!waiting) return tl::unexpected(waiting.error());
    if (!*waiting) return std::size_t{0};
    const int count = gpiod_line_request_read_edge_events(request_.get(), buffer_.get(), std::min(room, kKernelQueue));
    if (count < 0) return tl::unexpected(line_fault(line_, errno, {}));
    for (int i = 0; i < count; ++i) {
      gpiod_edge_event* const event = gpiod_edge_event_buffer_get_event(buffer_.get(), static_cast<unsigned long>(i));
      const unsigned long number = gpiod_edge_event_get_line_seqno(event);
      out[i] = {static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event)),
                gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE, number != last_ + 1};
      last_ = number;
    }
    return static_cast<std::size_t>(count);
  }

 private:
  config::GpioLine line_;
  Request request_;
  EdgeBuffer buffer_;
  unsigned long last_ = 0;  // the kernel numbers a line's edges from 1 on
};

class Output : public OutputLine {
 public:
  Output(config::GpioLine line, Request request) : line_(std::move(line)), request_(std::move(request)) {}
  tl::expected<void, std::string> set(bool level) override {
    const auto value = level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
    if (gpiod_line_request_set_value(request_.get(), line_.line, value) != 0)
      return tl::unexpected(line_fault(line_, errno, {}));
    return {};
  }

 private:
  config::GpioLine line_;
  Request request_;
};

}  // namespace

tl::expected<std::unique_ptr<InputLine>, std::string> KernelLines::input(const config::GpioLine& line, Edges edges) {
  const Settings settings(gpiod_line_settings_new());
  EdgeBuffer buffer(gpiod_edge_event_buffer_new(kKernelQueue));
  if (!settings || !buffer) return tl::unexpected(line_fault(line, ENOMEM, {}));
  gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_INPUT);
  gpiod_line_settings_set_edge_detection(settings.get(),
                                         edges == Edges::both ? GPIOD_LINE_EDGE_BOTH : GPIOD_LINE_EDGE_RISING);
  gpiod_line_settings_set_bias(settings.get(), bias_of(line));
  gpiod_line_settings_set_event_clock(settings.get(), GPIOD_LINE_CLOCK_MONOTONIC);
  auto held = hold(line, settings.get());
  if (!held) return tl::unexpected(held.error());
  return std::make_unique<Input>(line, std::move(*held), std::move(buffer));
}

tl::expected<std::unique_ptr<OutputLine>, std::string> KernelLines::output(const config::GpioLine& line, bool level) {
  const Settings settings(gpiod_line_settings_new());
  if (!settings) return tl::unexpected(line_fault(line, ENOMEM, {}));
  gpiod_line_settings_set_direction(settings.get(), GPIOD_LINE_DIRECTION_OUTPUT);
  gpiod_line_settings_set_output_value(settings.get(), level ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE);
  auto held = hold(line, settings.get());
  if (!held) return tl::unexpected(held.error());
  return std::make_unique<Output>(line, std::move(*held));
}

}  // namespace dwell::gpio
