// Keeps the sources of the drive's frequency other than the motion: the rig file's statement and the sync pulses. Tells
// whether they allow a dwell to begin, and whether the data contradict them.
//
// Reference::fixed: the statement is a prior. Reference::sync: the pulses give the frequency, nothing is fitted.
// Reference::tracked: there is neither.
#pragma once

#include <cstdint>
#include <string>

#include "core/drive/refine.hpp"
#include "core/drive/sync_reference.hpp"
#include "core/fit/frequency_prior.hpp"
#include "core/fit/harmonic_fit.hpp"
#include "core/fit/totals.hpp"
#include "core/rig/rig.hpp"

namespace dwell {

// Bound to one thread; real-time safe except for the constructor and functions that return text. The rig must outlive
// it. Angular frequencies in rad/s. A text is empty if nothing is wrong.
class DriveReference {
 public:
  explicit DriveReference(const Rig& rig);

  [[nodiscard]] const FrequencyPrior& stated() const noexcept { return stated_; }
  [[nodiscard]] bool synced() const noexcept { return rig_.excitation.reference == Reference::sync; }
  // Whether the motion shows the frequency while settling, with sync too. False: the rig file states it exactly.
  [[nodiscard]] bool inexact() const noexcept { return !stated_.exact(); }
  // Whether the final frequency comes from the motion (and the prior).
  [[nodiscard]] bool from_motion() const noexcept { return inexact() && !synced(); }

  // Takes the next pulse of the sync input.
  void pulse(std::int64_t t_ns) noexcept;
  // Begins a hold: missed() counts from now on.
  void begin_hold() noexcept { before_ = sync_.counts(); }

  // Whether pulses are the reference and do not come.
  [[nodiscard]] bool lost(std::int64_t now_ns) const noexcept { return synced() && !sync_.present(now_ns); }
  // Whether a dwell may begin. With pulses as the reference: only while they come, at a frequency in the search range.
  [[nodiscard]] bool usable(std::int64_t now_ns) const noexcept;
  // Why usable() is false.
  [[nodiscard]] std::string unusable_reason(std::int64_t now_ns) const;

  // Whether the pulses have another frequency than the table, which moves at `omega`; and the message that says so.
  [[nodiscard]] bool pulses_contradict(double omega) const noexcept;
  [[nodiscard]] std::string contradiction_of_pulses(double omega) const;
  // The message for a table that moves at `omega` while the rig file states another frequency. It does not test that.
  [[nodiscard]] std::string contradiction_of_statement(double omega) const;

  // Refines ω of the data over [from, to] and leaves the data at that ω in `out`, as core/drive/refine.hpp. `data`: at
  // an ω near the solution. The frequency has been the same since hold_ns. Too few pulses: u is NaN.
  [[nodiscard]] Refined refine(const Totals& data, std::int64_t from_ns, std::int64_t to_ns, std::int64_t hold_ns,
                               int drive_channel, Totals& out) const noexcept;
  // Why data refined so cannot give coefficients: the pulses or the statement contradict them. `table`: their fit of
  // the drive's channel. omega, u: refined ω and its standard uncertainty. by_refresh: standard uncertainty of the
  // data's ω by refreshes whose instants are not known.
  [[nodiscard]] std::string unfit_reason(const Refined& refined, const HarmonicFit& table, double omega, double u,
                                         double by_refresh) const;
  // The message on missed and extra pulses in this hold.
  [[nodiscard]] std::string missed() const;

 private:
  [[nodiscard]] std::string pulses_unfit(const HarmonicFit& table, double omega, double u) const;

  const Rig& rig_;
  FrequencyPrior stated_;
  SyncReference sync_;
  SyncReference::Counts before_;  // counts when this hold began
};

}  // namespace dwell
