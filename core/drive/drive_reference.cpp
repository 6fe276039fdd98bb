#include "core/drive/drive_reference.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/angle.hpp"
#include "core/base/chance.hpp"
#include "core/base/instants.hpp"
#include "core/base/wording.hpp"
#include "core/result/dwell.hpp"

namespace dwell {
namespace {

// Table and pulses contradict each other if their frequencies differ by more than this many tolerances.
constexpr double kContradicts = 2.0;
constexpr double kCovered = 0.5;  // part of the data's length that the pulses must span to give the frequency

std::string hz(double omega) { return std::to_string(omega / kTwoPi).substr(0, 8) + " Hz"; }
std::string in_hz(double omega) { return brief(omega / kTwoPi, 7); }

std::string two_frequencies(double table, double pulses) {
  return "the table moves at " + hz(table) + ", the sync pulses come at " + hz(pulses) +
         "; check that the input gives one pulse for each period";
}

}  // namespace

DriveReference::DriveReference(const Rig& rig)
    : rig_(rig), stated_(stated_frequency(rig)), sync_(rig.excitation.search_low_hz, rig.excitation.search_high_hz) {}

void DriveReference::pulse(std::int64_t t_ns) noexcept {
  if (synced()) sync_.pulse(t_ns);
}

bool DriveReference::usable(std::int64_t now_ns) const noexcept {
  const double f = sync_.omega() / kTwoPi;
  return !synced() ||
         (sync_.present(now_ns) && f >= rig_.excitation.search_low_hz && f <= rig_.excitation.search_high_hz);
}

std::string DriveReference::unusable_reason(std::int64_t now_ns) const {
  if (!synced()) return "";
  if (!sync_.present(now_ns)) {
    if (sync_.newest_ns() != INT64_MIN)
      return "no sync pulse for " + std::to_string(to_s(now_ns - sync_.newest_ns())).substr(0, 4) + " s";
    return "no sync pulse seen yet: expected one for each period of the drive; check the sync input";
  }
  if (!usable(now_ns)) return "the sync pulses come at " + hz(sync_.omega()) + ", outside the search range";
  return "";
}

bool DriveReference::pulses_contradict(double omega) const noexcept {
  return synced() && std::abs(omega / sync_.omega() - 1) > kContradicts * rig_.tolerance;
}

std::string DriveReference::contradiction_of_pulses(double omega) const {
  if (!pulses_contradict(omega)) return "";
  return two_frequencies(omega, sync_.omega());
}

std::string DriveReference::contradiction_of_statement(double omega) const {
  return "the drive is at " + in_hz(omega) + " Hz, the rig file says fixed at " + in_hz(stated_.omega) + " ± " +
         in_hz(2 * stated_.u) +
         " Hz (2 u, clock included): correct frequency or frequency_u, or take reference = \"tracked\"";
}

Refined DriveReference::refine(const Totals& data, std::int64_t from_ns, std::int64_t to_ns, std::int64_t hold_ns,
                               int drive_channel, Totals& out) const noexcept {
  if (!synced()) return dwell::refine(rig_, data, drive_channel, out);
  // Short data may hold too few pulses. The whole hold has the same frequency, so its pulses serve as well.
  for (const std::int64_t since_ns : {from_ns, std::min(from_ns, hold_ns)}) {
    const auto pulses = sync_.over(since_ns, to_ns);
    if (pulses && pulses->span_s >= kCovered * to_s(to_ns - from_ns))
      return dwell::refine(*pulses, data, drive_channel, out);
  }
  data.turned(data.omega(), data.centroid_ns(drive_channel), out);
  return {data.omega(), kNaN, true};
}

std::string DriveReference::unfit_reason(const Refined& refined, const HarmonicFit& table, double omega, double u,
                                         double by_refresh) const {
  if (std::string reason = pulses_unfit(table, omega, u); !reason.empty()) return reason;
  const bool contradicted = stated_.contradicted(refined.data_omega, std::hypot(refined.u_data, by_refresh));
  return contradicted ? contradiction_of_statement(refined.data_omega) : "";
}

std::string DriveReference::pulses_unfit(const HarmonicFit& table, double omega, double u) const {
  if (!synced()) return "";
  if (!std::isfinite(u)) return "too few sync pulses in the data that count";
  if (!(table.information > 0)) return "";
  const double off = table.score / table.information;
  const double explained =
      sigmas::kShown * std::hypot(u, 1 / std::sqrt(table.information)) + kToleranceShare * rig_.tolerance * omega;
  if (std::abs(off) <= explained) return "";
  return two_frequencies(omega + off, omega);
}

std::string DriveReference::missed() const {
  const SyncReference::Counts& now = sync_.counts();
  const std::uint64_t missed = now.missed - before_.missed, extra = now.extra - before_.extra;
  if (!synced() || missed + extra == 0) return "";
  return "sync pulses in this hold: " + std::to_string(now.pulses - before_.pulses) + " used, " +
         std::to_string(missed) + " missed, " + std::to_string(extra) + " extra";
}

}  // namespace dwell
