// All channels as they deliver; knows which of them shows the drive, and which are read together.
#pragma once

#include <cstdint>
#include <vector>

#include "core/intake/live_channel.hpp"
#include "core/rig/rig.hpp"
#include "core/stream/record.hpp"
#include "core/stream/transactions.hpp"

namespace dwell {

// Bound to one thread; real-time safe except for the constructor. The rig must outlive it.
class LiveChannels {
 public:
  explicit LiveChannels(const Rig& rig);

  [[nodiscard]] int count() const noexcept { return count_; }
  [[nodiscard]] LiveChannel& operator[](int c) noexcept { return channels_[static_cast<std::size_t>(c)]; }
  [[nodiscard]] const LiveChannel& operator[](int c) const noexcept { return channels_[static_cast<std::size_t>(c)]; }

  // The channel that shows the drive: the first on the table; else the first that sees motion; -1: none.
  [[nodiscard]] int drive() const noexcept { return drive_; }
  // Chooses the first channel on the table that delivers; none: leaves the choice as it was.
  void choose_drive(std::int64_t now_ns, double period_s) noexcept;
  // Per channel, 1: its motion is imposed (shows_drive()), and it has no transient of its own.
  [[nodiscard]] const std::vector<char>& on_table() const noexcept { return on_table_; }
  // The transaction in which a channel is read (Transactions::of).
  [[nodiscard]] int transaction_of(int c) const noexcept { return transactions_.of(c); }

  // The next sample of the stream, of a channel of this rig; omega_rad_s: of the drive.
  // take(LiveChannel&, const LiveChannel::Reading&) gets its channel and the readings that count now, the oldest first.
  template <class Take>
  void sample(const Record& record, double omega_rad_s, Take&& take) {
    LiveChannel& channel = channels_[record.channel];
    if (!channel.hear(record)) return;
    transactions_.sample(record);
    channel.judge(record, omega_rad_s, [&](const LiveChannel::Reading& reading) { take(channel, reading); });
  }

  // A sample that LiveChannel::take_plain() has judged before.
  void plain_sample(const Record& record) noexcept { transactions_.sample(record); }

  // As LiveChannel, for each channel.
  void begin_hold() noexcept;
  void begin_to_count() noexcept;
  void next_period() noexcept;

  // The register of some channel began or ceased to be held after the hold began.
  [[nodiscard]] bool holding_changed() const noexcept;
  // Standard uncertainty of ω, rad/s, by the uncertain instants of refreshes, for data of that length.
  [[nodiscard]] double refresh_u_omega(double seconds, double omega_rad_s) const noexcept;

 private:
  const Rig& rig_;
  int count_;  // of channels_; its size() would cost a division for each sample
  std::vector<LiveChannel> channels_;
  std::vector<char> on_table_;
  Transactions transactions_;
  int drive_ = -1;
};

}  // namespace dwell
