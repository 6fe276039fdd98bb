// What the drive's frequency is known from, beside the motion: what the rig file states of it, and the pulses of the
// sync input. Says whether a dwell may begin by these, and whether the data contradict them.
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

// Bound to one thread; real-time safe but for the constructor and what makes text. The rig must outlive it. Angular
// frequencies in rad/s. Texts are empty where nothing is wrong.
class DriveReference {
 public:
  explicit DriveReference(const Rig& rig);

  [[nodiscard]] const FrequencyPrior& stated() const noexcept { return stated_; }
  [[nodiscard]] bool synced() const noexcept { return rig_.excitation.reference == Reference::sync; }
  // While settling the motion itself shows the frequency, though pulses may give it in the end.
  [[nodiscard]] bool tracked() const noexcept { return !stated_.exact(); }
  // Whether only the motion tells the frequency, beside what is stated of it.
  [[nodiscard]] bool from_motion() const noexcept { return tracked() && !synced(); }

  // The next pulse of the sync input.
  void pulse(std::int64_t t_ns) noexcept;
  // A hold begins: missed() counts from now on.
  void begin_hold() noexcept { before_ = sync_.counts(); }

  // Pulses are needed and do not come.
  [[nodiscard]] bool lost(std::int64_t now_ns) const noexcept { return synced() && !sync_.present(now_ns); }
  // A dwell may begin: with pulses as the reference only while they come, within the range that is searched.
  [[nodiscard]] bool usable(std::int64_t now_ns) const noexcept;
  // Why not.
  [[nodiscard]] std::string unusable_reason(std::int64_t now_ns) const;

  // Whether the pulses have another frequency than the table, which moves at `omega` (rad/s); and the reason in words.
  [[nodiscard]] bool pulses_contradict(double omega) const noexcept;
  [[nodiscard]] std::string contradiction_of_pulses(double omega) const;
  // The reason in words, where the table moves at `omega` (rad/s) and the rig file states another frequency.
  [[nodiscard]] std::string contradiction_of_statement(double omega) const;

  // Data over [from, to], at an ω near the solution, at the best one for them: leaves them in `out`, as refine() of
  // core/drive/refine.hpp. The frequency has been the same since hold_ns.
  [[nodiscard]] Refined refine(const Totals& data, std::int64_t from_ns, std::int64_t to_ns, std::int64_t hold_ns,
                               int drive_channel, Totals& out) const noexcept;
  // Why data refined so cannot give coefficients: `table`, the drive's channel in them, moves at another ω than the
  // pulses'; u: of that. by_refresh: standard uncertainty of the data's ω by instants that are not known.
  [[nodiscard]] std::string unfit_reason(const Refined& refined, const HarmonicFit& table, double omega, double u,
                                         double by_refresh) const;
  // What pulses went amiss in this hold.
  [[nodiscard]] std::string missed() const;

 private:
  [[nodiscard]] std::string pulses_unfit(const HarmonicFit& table, double omega, double u) const;

  const Rig& rig_;
  FrequencyPrior stated_;
  SyncReference sync_;
  SyncReference::Counts before_;  // this hold
};

}  // namespace dwell
