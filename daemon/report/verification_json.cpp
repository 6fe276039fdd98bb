#include "daemon/report/verification_json.hpp"

#include <cmath>

#include "daemon/report/dwell_view.hpp"
#include "daemon/report/missing_report.hpp"

namespace dwell {
namespace {

Json number_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json channel_value(const ChannelComparison& c, const ChannelLabel& label) {
  return {{"channel", label.name},
          {"verdict", to_string(c.verdict)},
          {"fit_percent", number_or_null(c.fit_percent)},
          {"error", number_or_null(c.error)},
          {"U", number_or_null(c.U)},
          {"U_as_is", number_or_null(c.U_as_is)},
          {"e_n", number_or_null(c.e_n)},
          {"frac", number_or_null(c.frac)},
          {"sprague_geers",
           {{"magnitude", number_or_null(c.sprague_geers.magnitude)},
            {"phase", number_or_null(c.sprague_geers.phase)},
            {"combined", number_or_null(c.sprague_geers.combined)}}},
          {"samples", c.samples},
          {"rms", number_or_null(c.rms)},
          {"unit", label.unit},
          {"noise", number_or_null(c.noise)},
          {"beyond_steady", number_or_null(c.beyond_steady)}};
}

}  // namespace

Json json_value(const Verification& v, const Rig& rig, const Dwell& dwell) {
  const std::vector<ChannelLabel> labels = channel_labels(rig);
  Json object = {{"dwell", dwell.index ? Json(*dwell.index) : Json(nullptr)},
                 {"verdict", to_string(v.verdict)},
                 {"consistent", v.consistent ? Json(*v.consistent) : Json(nullptr)},
                 {"reasons", v.reasons},
                 {"e_n", number_or_null(v.e_n)},
                 {"chi2", number_or_null(v.chi2)},
                 {"p", number_or_null(v.p)},
                 {"accuracy", {{"asked", v.accuracy}, {"seen", number_or_null(v.seen)}, {"U", number_or_null(v.U)}}}};
  object["channels"] = Json::array();
  for (const ChannelComparison& c : v.channels)
    object["channels"].push_back(channel_value(c, labels[static_cast<std::size_t>(c.channel)]));
  object["missing"] = json_value(v.missing);
  object["evidence"] = v.evidence;
  object["cannot_be_checked"] = v.cannot_be_checked;
  return object;
}

}  // namespace dwell
