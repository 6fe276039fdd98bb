// Keeps the data that count: the samples of one dwell condensed into blocks, the sums over the blocks, and the
// frequency and drift of the drive at which these sums are taken.
//
// While a dwell settles the blocks hold data that may come to count; from the verdict on all of them count. The running
// sums over all blocks grow block by block. They are taken anew (resum) when the frequency is known better.
// Results rest on separate sums (gather, totals).
#pragma once

#include <cstdint>
#include <optional>
#include <span>
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

// Bound to one thread; real-time safe except for the constructor and stretches(). Its arguments must outlive it.
// Angular frequencies in rad/s. Blocks are named by their index (Blocks::block), ranges are [from, to).
class CountedData {
 public:
  CountedData(const Rig& rig, const LiveChannels& channels, const DriveReference& reference);

  // The best known ω; with a drift, ω at drift().about_ns.
  [[nodiscard]] double omega() const noexcept { return omega_; }
  [[nodiscard]] double period_s() const noexcept { return kTwoPi / omega_; }
  // Whether omega() differs from the rig file's nominal one.
  [[nodiscard]] bool knows_omega() const noexcept { return omega_ != nominal_omega(); }
  [[nodiscard]] double nominal_omega() const noexcept { return kTwoPi * rig_.excitation.frequency_hz; }
  void take_omega(double omega) noexcept { omega_ = omega; }
  void forget_omega() noexcept { omega_ = nominal_omega(); }
  // Takes ω and drift from outside: from the modal fit.
  void take_drive(double omega, const Blocks::Drift& drift) noexcept;
  // Estimates ω from one window of the drive's channel, centred at centre_ns, beginning at `near`. Keeps it if its
  // relative standard uncertainty is below a hundredth.
  void acquire(int from, int to, std::int64_t centre_ns, double near) noexcept;
  [[nodiscard]] const Blocks::Drift& drift() const noexcept { return blocks_.drift(); }
  // ω at t of a drifting drive that has `omega` at drift().about_ns.
  [[nodiscard]] double omega_at(std::int64_t t_ns, double omega) const noexcept;
  // Phase at t that the drift adds to a drive of constant ω, rad.
  [[nodiscard]] double bend(std::int64_t t_ns) const noexcept;
  // The rate in rad/s², on top of drift(), at which the table's frequency drifts over the blocks from `first` on. 0:
  // the drift is not significant, or turns a phasor too little. omega: the table's frequency at about_ns.
  [[nodiscard]] double seen_drift(int first, double omega, std::int64_t about_ns) const noexcept;

  [[nodiscard]] const Blocks& blocks() const noexcept { return blocks_; }
  void set_reference(int channel, double value) noexcept { blocks_.set_reference(channel, value); }
  // Opens a block of a quarter period.
  void open(std::int64_t begin_ns) noexcept;
  void add(int channel, std::int64_t t_ns, double value) noexcept { blocks_.add(channel, t_ns, value); }
  void close() noexcept { blocks_.close(); }
  void clear() noexcept { blocks_.clear(); }
  void restart() noexcept { blocks_.restart(); }
  // Adds the block just closed, which ends at end_ns, to the running sums. Forgets data older than the rig's memory.
  void take_block(std::int64_t end_ns) noexcept;
  // Drops all blocks that end at or before t.
  void forget_before(std::int64_t t_ns) noexcept { blocks_.forget_before(t_ns); }
  // The drive is steady from block `from` on; nothing counts yet.
  void begin_hold(int from) noexcept;
  // Nothing counts any more. ω becomes that at t, without a drift.
  void stop_counting(std::int64_t t_ns) noexcept;

  // Fits one channel over blocks [from, to) at ω, phases about t. `harmonics`: 1 … H.
  [[nodiscard]] HarmonicFit fit(int channel, int from, int to, double omega, std::int64_t t_ns,
                                int harmonics) const noexcept;
  [[nodiscard]] HarmonicFit fit(int channel, int from, int to, double omega, std::int64_t t_ns) const noexcept;
  // As fit(), for all channels at omega(), into `fits`, one per channel.
  void fit_all(int from, int to, std::int64_t t_ns, std::vector<HarmonicFit>& fits) const noexcept;
  // Fits one channel over blocks from `from` on and the open one, phases about t. counting: the running sums are used
  // where they are valid.
  [[nodiscard]] HarmonicFit fit_now(int channel, int from, bool counting, std::int64_t t_ns) const noexcept;

  // Whether the running sums cover all blocks.
  [[nodiscard]] bool sums_valid() const noexcept { return sums_valid_; }
  [[nodiscard]] const Totals& sums() const noexcept { return counted_; }
  [[nodiscard]] HarmonicFit fit_counted(int channel) const noexcept;
  // Whether the data have grown by a sixth since ω was refined.
  [[nodiscard]] bool wants_refining() const noexcept { return blocks_.serials() >= refine_at_serial_; }
  // All data of the table, as counted anew: the fit, phases about t_ref_ns, and the standard uncertainty of omega().
  struct Table {
    HarmonicFit fit;
    std::int64_t t_ref_ns;
    double u_omega;
  };
  // Takes ω, drift and running sums anew from all data that count. Called at the verdict, if wants_refining(), and
  // after the oldest data were forgotten. hold_ns: since when the drive has one frequency. None: there are no data.
  std::optional<Table> resum(std::int64_t hold_ns) noexcept;

  // Sums blocks [from, to), and with_open the open one, at the best ω for them, into totals().
  Refined gather(int from, int to, bool with_open, std::int64_t now_ns, std::int64_t hold_ns) const noexcept;
  [[nodiscard]] const Totals& totals() const noexcept { return totals_; }
  // Changes within blocks [from, to), whose sums totals() holds, by channel. fits: of all channels, from totals().
  // Allocates.
  [[nodiscard]] std::vector<std::vector<PhasorStretch>> stretches(int from, int to,
                                                                  std::span<const HarmonicFit* const> fits) const;

 private:
  [[nodiscard]] int H() const noexcept { return rig_.excitation.harmonics; }
  std::optional<Table> resum(std::int64_t hold_ns, bool follow) noexcept;
  bool follow_drift() noexcept;
  void refer_drift(std::int64_t about_ns) noexcept;
  bool drop_misjudged() noexcept;

  // Of the pipeline.
  const Rig& rig_;
  const LiveChannels& channels_;
  const DriveReference& reference_;
  // Its own.
  Blocks blocks_;
  mutable Totals window_;             // scratch for single questions
  Totals counted_;                    // all closed blocks of this dwell, kept up to date while measuring
  mutable Totals gathered_, totals_;  // of a result: as added up, and at the refined ω
  double omega_;
  bool sums_valid_ = false;
  std::int64_t refine_at_serial_ = 0;
};

}  // namespace dwell
