// Models the transient of one hold: the natural oscillations of the rig beside its steady motion (docs/method.md,
// Settling).
//
// While the rig settles the model follows the hold, fits it anew when that is due, and says how much of the transient
// is left. After the verdict it subtracts the transient from the readings that count, fits the hold anew as the data
// grow, and takes back a premature verdict. Each part owns its state; this class holds the parts and knows the order of
// their work. The pipeline decides what a verdict does to the dwell.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>

#include "core/rig/rig.hpp"
#include "core/stream/sample_history.hpp"
#include "core/transient/chain_poles.hpp"
#include "core/transient/foreign_lines.hpp"
#include "core/transient/hold_fit.hpp"
#include "core/transient/hold_now.hpp"
#include "core/transient/hold_refit.hpp"
#include "core/transient/knock_watch.hpp"
#include "core/transient/pole_search.hpp"
#include "core/transient/refit_schedule.hpp"
#include "core/transient/residual_noise.hpp"
#include "core/transient/settling.hpp"
#include "core/transient/shown_modes.hpp"
#include "core/transient/transient_left.hpp"
#include "core/transient/transient_removal.hpp"

namespace dwell {

// Bound to one thread. No allocation but in the constructor. Instants in ns. end_ns: the end of the newest block.
class TransientModel {
 public:
  // All must outlive this. history: the samples to be fitted. chain: gives the poles to start from.
  TransientModel(const Rig& rig, const FrequencyPrior& stated, const SampleHistory& history, ChainPoles& chain);
  TransientModel(const TransientModel&) = delete;
  TransientModel& operator=(const TransientModel&) = delete;

  // Begins a hold: the drive is steady from steady_ns on.
  void begin_hold(std::int64_t steady_ns) noexcept;
  // The noise of the channels. The pipeline tells it what windows show.
  [[nodiscard]] ResidualNoise& noise() noexcept { return noise_; }
  // Whether poles are believed. Then the fit tells more than windows do.
  [[nodiscard]] bool has_poles() const noexcept { return !search_.poles().chain.empty(); }

  // Whether less has been seen, since the hold's beginning or the last knock, than any verdict needs.
  [[nodiscard]] bool too_early(std::int64_t end_ns, const HoldNow& now) const noexcept;
  // Adds the new samples to the fit and watches them for knocks. Whether the hold is to be fitted anew.
  [[nodiscard]] bool wants_refit(std::int64_t end_ns, const HoldNow& now);
  // Fits the hold anew. false: it cannot be fitted.
  bool refit(const SeenFrequency& seen, std::int64_t end_ns, const HoldNow& now);
  // Whether there is a fit of this hold.
  [[nodiscard]] bool fitted() const noexcept { return schedule_.made_ns().has_value(); }
  struct Judgement {
    SettlingDetector::Verdict verdict;  // `settled` stays false
    // From where the data may count; empty: the rig has not settled, or not long enough ago.
    std::optional<std::int64_t> counts_from_ns;
  };
  // Judges by the fit as it is what is left of the transient. left_before: worst_left of the judgement before.
  [[nodiscard]] Judgement judge(double left_before, std::int64_t end_ns, const HoldNow& now);
  // Whether a sudden claim of rounded readings waits for a second fit.
  [[nodiscard]] bool unconfirmed() const noexcept { return schedule_.confirm_ns().has_value(); }

  // Call after a verdict: refits are then made as a measurement needs them.
  void begin_measuring(const HoldNow& now) noexcept;
  // From now on clean() subtracts the transient from readings from from_ns on. All that count are to be cleaned anew.
  void take_out(std::int64_t from_ns, std::int64_t end_ns, const HoldNow& now) noexcept;
  [[nodiscard]] double clean(int channel, std::int64_t t_ns, double value) noexcept {
    return removal_.clean(channel, t_ns, value);
  }
  // What clean() subtracts at t, in the channel's unit.
  [[nodiscard]] double transient(int channel, std::int64_t t_ns) noexcept { return removal_.transient(channel, t_ns); }
  // How often the fit may follow the drive's frequency after one verdict.
  static constexpr int kMostFollowed = 4;
  // Where the data that count have another frequency than the fit, tries it in the fit. Whether it explains the hold
  // better: the transient is then to be subtracted anew.
  bool follow_drive(const SeenFrequency& counted, const HoldNow& now);
  void allow_following() noexcept { fit_.allow_at_least(kMostFollowed); }

  // Whether a refit is due while measuring: more data tell better what the transient was.
  [[nodiscard]] bool wants_refit_measuring(const HoldNow& now) noexcept;
  // Refines the fit on all data. matters: whether the uncertainty of the transient matters in that of the phasors.
  // Whether this was the last refit of the hold: then end_refits() once its result is used.
  bool refit_measuring(const SeenFrequency& counted, bool matters, const HoldNow& now);
  void end_refits() noexcept { schedule_.plan_no_more(); }
  // Whether the fit takes back the verdict given at verdict_ns.
  [[nodiscard]] bool takes_back(std::int64_t verdict_ns, const HoldNow& now) noexcept;
  // After takes_back(): writes what is left into the verdict. From where the data count; empty: not settled.
  [[nodiscard]] std::optional<std::int64_t> mend(std::int64_t end_ns, const HoldNow& now,
                                                 SettlingDetector::Verdict& verdict) const noexcept;
  // Settles again, in the same hold and by the same fit.
  void settle_again(const HoldNow& now) noexcept;
  // Keeps the natural oscillations that the fit shows, for the check of the model.
  void remember_modes(const HoldNow& now) noexcept;

  // For the report.
  [[nodiscard]] const ModalFit& fit() const noexcept { return fit_.fit(); }
  [[nodiscard]] const PoleSet& poles() const noexcept { return search_.poles(); }
  [[nodiscard]] const TransientRemoval& removal() const noexcept { return removal_; }
  [[nodiscard]] std::span<const SeenMode> modes() const noexcept { return shown_.modes(); }
  // The verdict of this hold that was taken back last; empty: none.
  [[nodiscard]] const std::optional<TransientLeft::Premature>& taken_back() const noexcept { return taken_back_; }

 private:
  [[nodiscard]] bool explained(const HoldNow& now) const noexcept { return noise_.explained(fit_.fit(), now); }
  [[nodiscard]] bool same_drive(const SeenFrequency& counted, const HoldNow& now) const noexcept;
  void plan_growth(double growth, const HoldNow& now) noexcept {
    schedule_.plan_growth(growth, knocks_.free_since_ns(), now.now_ns);
  }
  void propagate_poles(const HoldNow& now) noexcept;
  void heed_knock(std::int64_t end_ns, const HoldNow& now) noexcept;
  void refit_after_knock(const HoldNow& now) noexcept;

  ChainPoles& chain_;  // owned by the pipeline
  HoldFit fit_;
  ResidualNoise noise_;
  KnockWatch knocks_;
  RefitSchedule schedule_;
  PoleSearch search_;
  ForeignLines lines_;
  HoldRefit refit_;
  TransientLeft left_;
  TransientRemoval removal_;
  ShownModes shown_;
  std::optional<TransientLeft::Premature> taken_back_;
};

}  // namespace dwell
