#include "daemon/service_view.hpp"

#include <cmath>
#include <memory>
#include <utility>

#include "daemon/record/utc_text.hpp"
#include "daemon/report/motion_report.hpp"
#include "daemon/serve/element_standing.hpp"

namespace dwell {
namespace {

// Why nothing of the dwell is known to be true now. Without an age: it is told apart, and the words must not change
// from one answer to the next.
std::string stale_reason(const ServiceView& now) {
  for (const Trouble& trouble : now.health.troubles)
    if (trouble.kind == TroubleKind::service) return "stale: the service itself does not work: " + trouble.text;
  return now.snapshot.sequence == 0 ? "the estimation has not published anything yet"
                                    : "stale: the estimation publishes nothing new";
}

// The verdict on a dwell's model; not_verified until the dwell has been verified. None: the service verifies no models,
// or the dwell has not settled.
std::optional<ModelVerdict> model_of(const ServiceView& now, const Dwell& dwell) {
  if (!now.verification.live || !std::isfinite(dwell.settled_s)) return std::nullopt;
  const auto* const known = dwell.index ? verdict_on(now.snapshot.models.get(), *dwell.index) : nullptr;
  if (known != nullptr) return known->model;
  ModelVerdict none;
  none.asked = now.verification.accuracy;
  return none;
}

std::optional<SinceBefore> since_before(const ServiceView& now, const Dwell& dwell) {
  if (!has_coefficients(dwell) || dwell.state == State::complete) return std::nullopt;
  const auto since = [&dwell](const Dwell& before, std::string start_utc) {
    return SinceBefore{before.index.value_or(0), std::move(start_utc), before.end_s, moves_since(before, dwell)};
  };
  if (const auto& finished = now.snapshot.finished)
    for (auto before = finished->rbegin(); before != finished->rend(); ++before)
      if (has_coefficients(**before) && (*before)->index != dwell.index) return since(**before, now.run.start_utc);
  if (const EarlierDwell& earlier = now.snapshot.earlier; earlier.dwell)
    return since(*earlier.dwell, record::iso_utc(earlier.start_utc_ns));
  return std::nullopt;
}

}  // namespace

DwellView live_dwell(const ServiceView& now) {
  const Snapshot& snapshot = now.snapshot;
  const bool stale = is_stale(now);
  Dwell dwell = snapshot.dwell;
  if (stale) dwell.doubts.insert(dwell.doubts.begin(), Doubt{{}, stale_reason(now)});
  DwellView view = make_view(dwell, now.rig, now.run, judge_limits_now(now.rig, dwell));
  view.age = LiveAge{estimate_age_s(snapshot, now.now_ns), stale};
  if (const auto& transient = snapshot.transient) {
    auto beside = std::make_shared<MotionView>(make_view(transient->estimate, snapshot.transient_agreement, now.rig));
    beside->from_s = transient->from_s;
    beside->until_s = transient->until_s;
    beside->given = transient->given;
    view.transient = std::move(beside);
  }
  if (!stale) view.model = model_of(now, snapshot.dwell);
  view.since = since_before(now, dwell);
  return view;
}

DwellView finished_dwell(const ServiceView& now, const Dwell& dwell) {
  DwellView view = make_view(dwell, now.rig, now.run);
  view.model = model_of(now, dwell);
  return view;
}

}  // namespace dwell
