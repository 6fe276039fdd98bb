#include "daemon/report/dwell_brief.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/rig/transducer.hpp"
#include "daemon/report/dwell_json.hpp"

namespace dwell {
namespace {

constexpr std::array kMembers{"index",        "state",    "ended_by", "start_s", "settled_s", "end_s",   "start_utc",
                              "frequency_hz", "elements", "limits",   "model",   "doubts",    "unstated"};

// How the table moved: the phasor of the first valid transducer on it.
Json table_json(const Json& whole, const Rig& rig) {
  const Json& phasors = whole["phasors"];
  for (std::size_t i = 0; i < std::min(phasors.size(), rig.channels.size()); ++i)
    if (shows_drive(rig.channels[i]) && phasors[i]["valid"])
      return {{"channel", phasors[i]["channel"]},
              {"amplitude", phasors[i]["amplitude"]},
              {"u_amplitude", phasors[i]["u_amplitude"]},
              {"unit", phasors[i]["unit"]}};
  return nullptr;
}

}  // namespace

Json brief_json(const DwellView& dwell, const Rig& rig) {
  const Json whole = json_value(dwell, Detail::moving);
  Json brief;
  for (const char* member : kMembers)
    if (whole.contains(member)) brief[member] = whole[member];
  for (Json& element : brief["elements"])
    for (const char* more : {"deformation", "loss_factor"}) element.erase(more);
  brief["table"] = table_json(whole, rig);
  return brief;
}

}  // namespace dwell
