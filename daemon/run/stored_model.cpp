#include "daemon/run/stored_model.hpp"

#include <memory>

#include "core/motion/transient_watch.hpp"
#include "core/verify/verification_watch.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/report/motion_report.hpp"
#include "daemon/report/objection_json.hpp"
#include "daemon/report/verification_json.hpp"

namespace dwell {
namespace {

// The readings that something was computed from: so many up to the number `last`.
Json stretch(std::uint64_t last, std::size_t readings, double from_s, double until_s) {
  return {{"last", last}, {"readings", readings}, {"from_s", json_number(from_s)}, {"until_s", json_number(until_s)}};
}

record::StoredModel stored(const TransientEstimate& of, const Rig& rig) {
  MotionView view = make_view(of.estimate, {}, rig);
  view.from_s = of.from_s;
  view.until_s = of.until_s;
  view.given = of.given;
  const Json result{
      {"motion", json_value(view)}, {"motion_reason", of.estimate.reason}, {"objection", json_objection(of)}};
  return {"estimate", 0, {}, dump(stretch(of.last, of.given, of.from_s, of.until_s)), dump(result)};
}

record::StoredModel stored(const VerifiedDwell& of, const Rig& rig) {
  const Json from{
      {"position", of.position}, {"ended", of.ended}, {"evidence", stretch(of.last, of.given, of.from_s, of.until_s)}};
  return {"verification", 0, {}, dump(from), dump(json_value(of.verification, rig, of.dwell))};
}

}  // namespace

record::StoredModel stored_model(const record::ModelResult& result, const Rig& rig) {
  return std::visit([&](const auto& of) { return stored(*of, rig); }, result);
}

}  // namespace dwell
