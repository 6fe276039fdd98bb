#include "daemon/report/model_entry.hpp"

#include <algorithm>

#include "daemon/report/json_parts.hpp"
#include "daemon/report/json_reader.hpp"
#include "daemon/report/motion_report.hpp"
#include "daemon/report/objection_json.hpp"
#include "daemon/report/verification_json.hpp"

namespace dwell {

using namespace json_reader;

namespace {

// The readings that something was computed from: so many up to the number `last`.
template <class Of>
Json stretch_json(const Of& of) {
  return {{"last", of.last},
          {"readings", of.given},
          {"from_s", json_number(of.from_s)},
          {"until_s", json_number(of.until_s)}};
}

template <class Of>
void read_stretch(const Json& from, Of& of) {
  of.last = natural_of(from, "last");
  of.given = natural_of(from, "readings");
  of.from_s = real_of(from, "from_s");
  of.until_s = real_of(from, "until_s");
}

Json json_faults(const std::vector<ChannelFault>& faults, const Rig& rig) {
  Json out = Json::array();
  for (const ChannelFault& fault : faults)
    out.push_back({{"channel", rig.channels[static_cast<std::size_t>(fault.channel)].name}, {"what", fault.what}});
  return out;
}

std::vector<ChannelFault> faults_in(const Json& from, const Rig& rig) {
  std::vector<ChannelFault> out;
  for (const Json& fault : array_of(from, "at_fault")) {
    const std::string name = string_of(fault, "channel");
    const auto at = std::find_if(rig.channels.begin(), rig.channels.end(),
                                 [&](const Channel& channel) { return channel.name == name; });
    if (at == rig.channels.end()) fail("channel", "one of the rig file's");
    out.push_back({static_cast<int>(at - rig.channels.begin()), string_of(fault, "what")});
  }
  return out;
}

// What read() makes of the text, or why it cannot.
template <class Read>
auto read_from(const std::string& text, const Read& read) -> tl::expected<decltype(read(Json())), std::string> {
  try {
    return read(Json::parse(text, nullptr, false));
  } catch (const Mistake& mistake) {
    return tl::unexpected<std::string>(std::string("from: ") + mistake.what());
  }
}

}  // namespace

ModelEntry model_entry(const TransientEstimate& of, const Rig& rig) {
  MotionView view = make_view(of.estimate, {}, rig);
  view.from_s = of.from_s;
  view.until_s = of.until_s;
  view.given = of.given;
  Json from = stretch_json(of);
  from["dwell"] = of.dwell ? Json(*of.dwell) : Json(nullptr);
  from["may_search"] = of.may_search;
  from["at_fault"] = json_faults(of.at_fault, rig);
  return {dump(from),
          dump(Json{
              {"motion", json_value(view)}, {"motion_reason", of.estimate.reason}, {"objection", json_objection(of)}})};
}

ModelEntry model_entry(const VerifiedDwell& of, const Rig& rig) {
  return {dump(Json{{"position", of.position}, {"ended", of.ended}, {"evidence", stretch_json(of)}}),
          dump(json_value(of.verification, rig, of.dwell))};
}

tl::expected<std::optional<TransientEstimate>, std::string> estimate_in(const std::string& from, const Rig& rig) {
  return read_from(from, [&](const Json& object) -> std::optional<TransientEstimate> {
    TransientEstimate of;
    read_stretch(object, of);
    if (object.find("may_search") == object.end()) return std::nullopt;
    of.may_search = boolean_of(object, "may_search");
    of.at_fault = faults_in(object, rig);
    if (const Json& dwell = member(object, "dwell"); !dwell.is_null()) of.dwell = integer(dwell, "dwell");
    return of;
  });
}

tl::expected<VerifiedDwell, std::string> verified_in(const std::string& from) {
  return read_from(from, [](const Json& object) {
    VerifiedDwell of;
    of.position = natural_of(object, "position");
    of.ended = boolean_of(object, "ended");
    read_stretch(member(object, "evidence"), of);
    return of;
  });
}

}  // namespace dwell
