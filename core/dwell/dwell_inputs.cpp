#include "core/dwell/pipeline_impl.hpp"

namespace dwell {
namespace {

constexpr double kContradicts = 2.0;  // tolerances between the table's frequency and that of the pulses
constexpr double kSureOfOff = 4.0;    // standard deviations …
constexpr double kOffMatters = 0.1;   // … and tolerances between the two in the data that count
constexpr double kCovered = 0.5;      // part of the data that the pulses must span to tell their frequency

std::string hz(double omega) { return std::to_string(omega / kTwoPi).substr(0, 8) + " Hz"; }

}  // namespace

void Pipeline::Impl::edge(const Record& record) {
  const bool active = record.value > 0.5;
  if (record.channel == static_cast<std::uint16_t>(Line::sync)) {
    if (synced() && active && !(record.flags & kStampReplaced)) sync.pulse(record.t_ns);
    return;
  }
  if (record.channel != static_cast<std::uint16_t>(Line::interlock)) return;
  // Edges that were lost before this one may have told of a loss.
  const bool lost = !active || (record.flags & kGap) != 0;
  if (permitted && lost) {
    end(EndedBy::interlock, State::idle, false);
    omega = kTwoPi * rig.excitation.frequency_hz;
  }
  if (active && (!permitted || lost)) {
    blocks.close();
    blocks.clear();
    open_block(record.t_ns);
  }
  permitted = active;
}

bool Pipeline::Impl::has_reference() const {
  const double f = sync.omega() / kTwoPi;
  return !synced() || (sync.present(now_ns) && f >= rig.excitation.search_low_hz && f <= rig.excitation.search_high_hz);
}

bool Pipeline::Impl::pulses_contradict() const {
  return synced() && std::abs(drive.omega() / sync.omega() - 1) > kContradicts * rig.tolerance;
}

std::string Pipeline::Impl::reference_reason() const {
  if (!synced()) return "";
  if (!sync.present(now_ns)) {
    if (sync.newest_ns() != INT64_MIN)
      return "no sync pulse for " + std::to_string(to_s(now_ns - sync.newest_ns())).substr(0, 4) + " s";
    return "no sync pulses, one for each period of the drive, have come";
  }
  if (!has_reference()) return "the sync pulses come at " + hz(sync.omega()) + ", outside the range that is searched";
  if (state == State::settling && pulses_contradict())
    return "the table moves at " + hz(drive.omega()) + ", the sync pulses come at " + hz(sync.omega());
  return "";
}

std::string Pipeline::Impl::pulses_unfit(double w, double u) const {
  if (!synced()) return "";
  if (!std::isfinite(u)) return "too few sync pulses among the data that count";
  const HarmonicFit table = fit_harmonics(totals, drive_channel(), H, blocks.reference(drive_channel()));
  if (!(table.information > 0)) return "";
  const double off = table.score / table.information;
  const double explained =
      kSureOfOff * std::hypot(u, 1 / std::sqrt(table.information)) + kOffMatters * rig.tolerance * w;
  if (std::abs(off) <= explained) return "";
  return "the table moves at " + hz(w + off) + ", the sync pulses come at " + hz(w);
}

void Pipeline::Impl::warn_of_pulses(Dwell& dwell) const {
  if (!synced()) return;
  const SyncReference::Counts& now = sync.counts();
  const std::uint64_t missed = now.missed - pulses_before.missed, extra = now.extra - pulses_before.extra;
  if (missed + extra == 0) return;
  dwell.warnings.push_back("of the sync pulses " + std::to_string(missed) + " did not come and " +
                           std::to_string(extra) + " came beside the others (" +
                           std::to_string(now.pulses - pulses_before.pulses) + " are used)");
}

Refined Pipeline::Impl::refine_sums(const Totals& sums, std::int64_t from_ns, std::int64_t to_ns) const {
  if (!synced()) return refine(rig, sums, drive_channel(), totals);
  // Where the data are short, the rest of the hold had the same frequency.
  for (const std::int64_t since_ns : {from_ns, std::min(from_ns, steady_ns)}) {
    const auto pulses = sync.over(since_ns, to_ns);
    if (pulses && pulses->span_s >= kCovered * to_s(to_ns - from_ns))
      return refine(*pulses, sums, drive_channel(), totals);
  }
  sums.turned(sums.omega(), sums.centroid_ns(drive_channel()), totals);
  return {sums.omega(), kNaN, true};
}

}  // namespace dwell
