#include "daemon/service_view.hpp"

#include <cmath>
#include <memory>

#include "daemon/report/motion_report.hpp"

namespace dwell {

DwellView live_dwell(const ServiceView& now) {
  const Snapshot& snapshot = now.snapshot;
  DwellView view = make_view(snapshot.dwell, now.rig, now.run);
  if (const auto& transient = snapshot.transient) {
    auto beside = std::make_shared<MotionView>(make_view(transient->estimate, snapshot.transient_e_n, now.rig));
    beside->from_s = transient->from_s;
    beside->until_s = transient->until_s;
    beside->given = transient->given;
    view.transient = std::move(beside);
  }
  if (!std::isfinite(snapshot.dwell.settled_s)) return view;
  view.model.emplace();
  view.model->asked = now.accuracy;
  if (const auto& verified = snapshot.verified; verified && verified->dwell.index == snapshot.dwell.index) {
    const Verification& v = verified->verification;
    view.model = ModelVerdict{v.verdict, v.consistent, v.accuracy, v.seen, v.U};
  }
  return view;
}

}  // namespace dwell
