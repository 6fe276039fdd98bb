#include <algorithm>

#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/json_parts.hpp"
#include "daemon/report/missing_report.hpp"
#include "daemon/report/motion_report.hpp"

namespace dwell {
namespace {

Json json_value(const Agreement& agreement) {
  return {{"e_n", json_number(agreement.e_n)},
          {"agrees", !agreement.contradicts},
          {"element", agreement.element},
          {"coefficient", to_string(agreement.kind)},
          {"difference", json_number(agreement.over_U)}};
}

}  // namespace

Json json_value(const MotionView& view, Detail detail) {
  const MotionEstimate& m = view.estimate;
  if (!m.reason.empty() && m.missing.empty()) return nullptr;
  Json object = {{"start_s", json_number(m.start_s)}, {"end_s", json_number(m.end_s)}};
  Json elements = Json::array();
  for (const ElementEstimate& e : m.elements) elements.push_back(json_element(e, view.motion, detail));
  object["elements"] = std::move(elements);
  if (detail == Detail::whole) object["covariance"] = json_square(m.covariance);
  object["frequency_hz"] = nullptr;  // no steady drive is part of this model
  Json channels = Json::array();
  for (const MotionChannel& channel : m.channels) {
    const ChannelLabel& label = view.channels[static_cast<std::size_t>(channel.channel)];
    channels.push_back({{"channel", label.name},
                        {"u_noise", json_number(channel.u_noise)},
                        {"unit", label.unit},
                        {"chi2", json_number(channel.chi2)},
                        {"whiteness_p", json_number(channel.whiteness_p)},
                        {"unexplained", json_number(channel.unexplained)}});
  }
  object["channels"] = std::move(channels);
  object["missing"] = json_value(m.missing);
  object["cannot_be_checked"] = m.unchecked;
  object["agrees_with_dwell"] = view.agreement ? json_value(*view.agreement) : Json(nullptr);
  object["readings"] = m.readings;
  object["given"] = view.given == 0 ? Json(nullptr)
                                    : Json{{"from_s", json_number(view.from_s)},
                                           {"until_s", json_number(view.until_s)},
                                           {"readings", view.given}};
  object["warnings"] = m.warnings;
  return object;
}

}  // namespace dwell
