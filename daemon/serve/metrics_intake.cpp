#include "daemon/calibration.hpp"
#include "daemon/serve/channel_status.hpp"
#include "daemon/serve/element_standing.hpp"
#include "daemon/serve/metrics.hpp"

namespace dwell {
namespace {

// A family with one sample for each channel.
template <class Value>
void each_channel(const ServiceView& now, Exposition& out, Value value) {
  for (std::size_t i = 0; i < now.snapshot.channels.size(); ++i)
    out.sample(value(now.snapshot.channels[i]), {{"channel", now.rig.channels[i].name}});
}

// States of channels and devices. Left out while stale: an old state would look like the current one.
void write_channel_states(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_channel_up", "1: the channel delivers.");
  each_channel(now, out, [](const ChannelView& c) { return c.fault == Fault::none ? 1.0 : 0.0; });
  out.gauge("dwell_channel_status",
            "1 beside the channel's status: ok, what is wrong with its readings, or why there are none.");
  for (std::size_t i = 0; i < now.snapshot.channels.size(); ++i)
    out.sample(1.0, {{"channel", now.rig.channels[i].name}, {"status", status_of(now.snapshot.channels[i])}});
  out.gauge("dwell_channel_rate_hertz",
            "Samples per second of the channel, over the last second. Absent: it does not deliver.");
  each_channel(now, out, delivered_rate_hz);
  out.gauge(
      "dwell_channel_jitter_seconds",
      "Standard deviation of the stamps from the clock recognized in them. Absent: none is, or it does not deliver.");
  each_channel(now, out, delivered_jitter_s);
  out.gauge("dwell_channel_queued_samples", "Samples on their way to the estimation.");
  each_channel(now, out, [](const ChannelView& c) { return count_value(c.tally.queued); });
  out.gauge("dwell_device_up", "1: at least one channel of the device delivers.");
  for (const DeviceView& device : now.snapshot.devices)
    out.sample(device.up ? 1.0 : 0.0, {{"device", device.name}, {"driver", device.driver}});
}

void write_channels(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_channel_reading_age_seconds", "Since the channel's newest reading was taken in. Absent: none was.");
  each_channel(now, out, [&](const ChannelView& c) { return reading_age_s(c, now.now_ns); });
  out.counter("dwell_channel_received_samples_total",
              "Samples handed in by the driver. They are used, dropped or queued.");
  each_channel(now, out, [](const ChannelView& c) { return count_value(c.tally.received); });
  out.counter("dwell_channel_used_samples_total", "Samples that the estimation took into account.");
  each_channel(now, out, [](const ChannelView& c) { return count_value(c.tally.used); });
  out.counter("dwell_channel_lost_samples_total", "Samples recognized as lost before they arrived.");
  each_channel(now, out, [](const ChannelView& c) { return count_value(c.clock.lost); });
  out.counter("dwell_channel_gaps_total", "Times that samples of the channel were lost.");
  each_channel(now, out, [](const ChannelView& c) { return count_value(c.gaps); });
}

void write_calibrations(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_channel_calibration_due_timestamp_seconds",
            "When the channel's calibration becomes overdue, since 1970. Absent: the rig file states no date.");
  for (const Channel& channel : now.rig.channels)
    if (const auto ends_s = calibration_ends_s(channel)) out.sample(*ends_s, {{"channel", channel.name}});
}

void write_dropped(const ServiceView& now, Exposition& out) {
  struct Reason {
    const char* name;
    std::uint64_t Tally::*count;
  };
  constexpr Reason kReasons[] = {{"refused", &Tally::refused},
                                 {"late", &Tally::late},
                                 {"ahead", &Tally::ahead},
                                 {"overflow", &Tally::overflow},
                                 {"rejected", &Tally::rejected}};
  out.counter("dwell_channel_dropped_samples_total", "Samples dropped on the way to the estimation, by the reason.");
  for (std::size_t i = 0; i < now.snapshot.channels.size(); ++i)
    for (const Reason& reason : kReasons)
      out.sample(count_value(now.snapshot.channels[i].tally.*reason.count),
                 {{"channel", now.rig.channels[i].name}, {"reason", reason.name}});
}

void write_devices(const ServiceView& now, Exposition& out) {
  out.counter("dwell_device_faults_total", "Faults of the device, by their kind.");
  for (const DeviceView& device : now.snapshot.devices)
    for (int kind = 1; kind < kFaultCount; ++kind)
      out.sample(count_value(device.faults[static_cast<std::size_t>(kind)]),
                 {{"device", device.name}, {"fault", to_string(static_cast<Fault>(kind))}});
  out.counter("dwell_device_foreign_readings_total",
              "Readings that the driver handed in for channels of other devices.");
  for (const DeviceView& device : now.snapshot.devices)
    out.sample(count_value(device.foreign), {{"device", device.name}});
}

// A family with one sample for each line that is configured.
template <class Value>
void each_line(const ServiceView& now, Exposition& out, Value value) {
  for (std::size_t i = 0; i < gpio::kFunctions; ++i)
    if (now.gpio[i].configured) out.sample(value(now.gpio[i]), {{"line", gpio::kFunctionNames[i]}});
}

void write_lines(const ServiceView& now, Exposition& out) {
  out.gauge("dwell_gpio_up", "1: the GPIO line works.");
  each_line(now, out, [](const gpio::LineStatus& line) { return line.works ? 1.0 : 0.0; });
  out.gauge("dwell_gpio_active", "1: the GPIO line is active. Absent: not known.");
  each_line(now, out, [](const gpio::LineStatus& line) { return line.level ? (*line.level ? 1.0 : 0.0) : kNaN; });
  out.counter("dwell_gpio_edges_total", "Edges of the GPIO line that counted.");
  each_line(now, out, [](const gpio::LineStatus& line) { return count_value(line.edges); });
  out.counter("dwell_gpio_lost_edges_total", "Edges of the GPIO line that were lost.");
  each_line(now, out, [](const gpio::LineStatus& line) { return count_value(line.lost); });
}

}  // namespace

void write_intake_metrics(const ServiceView& now, Exposition& out) {
  if (!is_stale(now)) write_channel_states(now, out);
  write_channels(now, out);
  write_calibrations(now, out);
  write_dropped(now, out);
  write_devices(now, out);
  write_lines(now, out);
}

}  // namespace dwell
