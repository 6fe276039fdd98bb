// The data that count: the samples of one dwell condensed into blocks, the sums over them, and the frequency and drift
// of the drive that these sums are of.
//
// While a dwell settles the blocks hold what may come to count; from the verdict on all of them count. The running sums
// over all blocks are kept up to date block by block, and are taken anew (count_anew) when the frequency is known
// better. What is reported rests on sums of its own (gather, totals).
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/drive/drive_reference.hpp"
#include "core/drive/refine.hpp"
#include "core/fit/blocks.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/fit/scatter.hpp"
#include "core/fit/totals.hpp"
#include "core/intake/live_channels.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Bound to one thread; real-time safe but for the constructor and stretches(). What it is given must outlive it.
// Angular frequencies in rad/s; blocks are named by their index (Blocks::block), ranges are [from, to).
class CountedData {
 public:
  CountedData(const Rig& rig, const LiveChannels& channels, const DriveReference& reference);

  // ω as best known: where it drifts, at drift().about_ns.
  [[nodiscard]] double omega() const noexcept { return omega_; }
  [[nodiscard]] double period_s() const noexcept { return kTwoPi / omega_; }
  // It is another than the rig file's nominal one.
  [[nodiscard]] bool knows_omega() const noexcept { return omega_ != nominal_omega(); }
  void take_omega(double omega) noexcept { omega_ = omega; }
  void forget_omega() noexcept { omega_ = nominal_omega(); }
  // ω and drift from elsewhere: of the modal fit.
  void take_drive(double omega, const Blocks::Drift& drift) noexcept;
  // ω from one window of the drive's channel, centred at centre_ns, where that is known to a hundredth.
  void acquire(int from, int to, std::int64_t centre_ns) noexcept;
  [[nodiscard]] const Blocks::Drift& drift() const noexcept { return blocks_.drift(); }
  // ω at t, where the drive drifts and has `omega` at drift().about_ns.
  [[nodiscard]] double omega_at(std::int64_t t_ns, double omega) const noexcept;
  // Phase of the drifting drive at t beyond that of a drive without drift, rad.
  [[nodiscard]] double bend(std::int64_t t_ns) const noexcept;
  // The rate, rad/s² beyond drift(), by which the table's frequency drifts over the blocks from `first` on; 0: it does
  // not show, or turns nothing by what matters. omega: its frequency at `about`.
  [[nodiscard]] double seen_drift(int first, double omega, std::int64_t about_ns) const noexcept;

  [[nodiscard]] const Blocks& blocks() const noexcept { return blocks_; }
  void set_reference(int channel, double value) noexcept { blocks_.set_reference(channel, value); }
  // Opens a block of a quarter period.
  void open(std::int64_t begin_ns) noexcept;
  void add(int channel, std::int64_t t_ns, double value) noexcept { blocks_.add(channel, t_ns, value); }
  void close() noexcept { blocks_.close(); }
  void clear() noexcept { blocks_.clear(); }
  void restart() noexcept { blocks_.restart(); }
  // The block just closed, which ends at end_ns, is added to the running sums; what is older than the rig's memory is
  // forgotten.
  void take_block(std::int64_t end_ns) noexcept;
  // Drops all blocks that end at or before t.
  void forget_before(std::int64_t t_ns) noexcept { blocks_.forget_before(t_ns); }
  // The drive is steady from block `from` on; nothing counts yet.
  void begin_hold(int from) noexcept;
  // Nothing counts any more; ω is that at t, without a drift.
  void stop_counting(std::int64_t t_ns) noexcept;

  // The fit of one channel over blocks [from, to) at ω, about t; `harmonics`: 1 … H.
  [[nodiscard]] HarmonicFit fit(int channel, int from, int to, double omega, std::int64_t t_ns,
                                int harmonics) const noexcept;
  [[nodiscard]] HarmonicFit fit(int channel, int from, int to, double omega, std::int64_t t_ns) const noexcept;
  // The same of all channels at omega(), into `fits`, one per channel.
  void fit_all(int from, int to, std::int64_t t_ns, std::vector<HarmonicFit>& fits) const noexcept;
  // One channel over blocks from `from` on and the open one, about t. counting: the dwell's own sums will do.
  [[nodiscard]] HarmonicFit fit_now(int channel, int from, bool counting, std::int64_t t_ns) const noexcept;

  // The running sums are those of all blocks.
  [[nodiscard]] bool counted() const noexcept { return counted_valid_; }
  [[nodiscard]] const Totals& sums() const noexcept { return counted_; }
  [[nodiscard]] HarmonicFit fit_counted(int channel) const noexcept;
  // The data have grown by a sixth since ω was refined.
  [[nodiscard]] bool wants_refining() const noexcept { return blocks_.serials() >= refine_at_serial_; }
  // What all data say of the table, as counted anew: its fit about t_ref_ns, and the standard uncertainty of omega().
  struct Table {
    HarmonicFit fit;
    std::int64_t t_ref_ns;
    double u_omega;
  };
  // ω, drift and running sums from all data that count: at the verdict, when wants_refining(), and when the oldest have
  // been forgotten. The drive's frequency has been the same since hold_ns. None: there are no data.
  std::optional<Table> count_anew(std::int64_t hold_ns) noexcept;

  // The sums over blocks [from, to), and the open one, at the best ω for them: leaves them in totals().
  Refined gather(int from, int to, bool with_open, std::int64_t now_ns, std::int64_t hold_ns) const noexcept;
  [[nodiscard]] const Totals& totals() const noexcept { return totals_; }
  // What blocks [from, to), which totals() hold, say of change within them: channel's `fit` is of totals(). Allocates.
  [[nodiscard]] std::vector<PhasorStretch> stretches(int channel, int from, int to, const HarmonicFit& fit) const;
  [[nodiscard]] PhasorSlope slope(int channel, const HarmonicFit& fit) const noexcept;

 private:
  [[nodiscard]] double nominal_omega() const noexcept { return kTwoPi * rig_.excitation.frequency_hz; }
  [[nodiscard]] int H() const noexcept { return rig_.excitation.harmonics; }
  std::optional<Table> count_anew(std::int64_t hold_ns, bool follow) noexcept;
  bool follow_drift() noexcept;
  void refer_drift(std::int64_t about_ns) noexcept;
  bool drop_misjudged() noexcept;

  // Of the pipeline.
  const Rig& rig_;
  const LiveChannels& channels_;
  const DriveReference& reference_;
  // Its own.
  Blocks blocks_;
  mutable Totals window_;             // what is asked for once
  Totals counted_;                    // all closed blocks of this dwell, kept up to date while measuring
  mutable Totals gathered_, totals_;  // what a result rests on: as added up, and at the refined frequency
  double omega_;
  bool counted_valid_ = false;
  std::int64_t refine_at_serial_ = 0;
};

}  // namespace dwell
