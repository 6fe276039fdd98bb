#include "core/intake/live_channels.hpp"

#include <algorithm>
#include <cmath>

#include "core/rig/transducer.hpp"

namespace dwell {

LiveChannels::LiveChannels(const Rig& rig)
    : rig_(rig), count_(static_cast<int>(rig.channels.size())), transactions_(rig) {
  channels_.reserve(rig.channels.size());
  for (int c = 0; c < static_cast<int>(rig.channels.size()); ++c) {
    const Channel& channel = rig.channels[static_cast<std::size_t>(c)];
    channels_.emplace_back(channel);
    on_table_.push_back(shows_drive(channel));
    if (shows_drive(channel) && drive_ < 0) drive_ = c;
  }
  for (int c = 0; c < count() && drive_ < 0; ++c) {
    const Quantity measures = rig.channels[static_cast<std::size_t>(c)].measures;
    if (measures != Quantity::force && measures != Quantity::auxiliary) drive_ = c;
  }
}

void LiveChannels::choose_drive(std::int64_t now_ns, double period_s) noexcept {
  for (int c = 0; c < count(); ++c)
    if (on_table_[static_cast<std::size_t>(c)] && (*this)[c].delivers(now_ns, period_s)) {
      drive_ = c;
      return;
    }
}

void LiveChannels::begin_hold() noexcept {
  for (LiveChannel& channel : channels_) channel.begin_hold();
}

void LiveChannels::begin_to_count() noexcept {
  for (LiveChannel& channel : channels_) channel.begin_to_count();
}

void LiveChannels::next_period() noexcept {
  for (LiveChannel& channel : channels_) channel.next_period();
}

bool LiveChannels::holding_changed() const noexcept {
  return std::any_of(channels_.begin(), channels_.end(),
                     [](const LiveChannel& channel) { return channel.intake().holding_changed(); });
}

// An error of the instants at either end of the data turns the phase there; the two errors are independent.
double LiveChannels::refresh_u_omega(double seconds, double omega_rad_s) const noexcept {
  double half_s = 0.0;
  for (int c = 0; c < count(); ++c)
    if (rig_.channels[static_cast<std::size_t>(c)].measures != Quantity::auxiliary)
      half_s = std::max(half_s, (*this)[c].intake().refresh_half_s());
  return omega_rad_s * half_s * std::sqrt(2.0 / 3.0) / std::max(seconds, 1e-9);
}

}  // namespace dwell
