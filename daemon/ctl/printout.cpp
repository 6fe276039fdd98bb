#include "daemon/ctl/printout.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {

Printout printout(const Rig& rig, const RunInfo& info, const std::vector<Dwell>& dwells) {
  Printout out{{{"rig", rig.name}, {"dwells", Json::array()}}, "rig " + printable(rig.name) + "\n"};
  for (const Dwell& dwell : dwells) {
    const DwellView view = make_view(dwell, rig, info);
    out.document["dwells"].push_back(json_value(view));
    out.text.append("\n").append(dwell_text(view));
  }
  return out;
}

void print(const Printout& out, bool json) {
  const std::string text = json ? dump(out.document, 2) + "\n" : out.text;
  std::fwrite(text.data(), 1, text.size(), stdout);
}

bool answers(const Dwell& dwell) {
  return std::isfinite(dwell.settled_s) && dwell.doubts.empty() &&
         std::any_of(dwell.elements.begin(), dwell.elements.end(),
                     [](const ElementEstimate& e) { return e.identifiable; });
}

int judge(const Rig& rig, const RecordSource& source, const std::vector<Dwell>& dwells) {
  const bool settled =
      std::any_of(dwells.begin(), dwells.end(), [](const Dwell& d) { return std::isfinite(d.settled_s); });
  const bool answered = std::any_of(dwells.begin(), dwells.end(), answers);
  const bool doubted = std::any_of(dwells.begin(), dwells.end(), [](const Dwell& d) { return !d.doubts.empty(); });
  if (!settled)
    tell_error(why_nothing_settled(rig, source, dwells));
  else if (doubted)
    tell_error("there are coefficients that must not be relied on; the reasons stand with the dwell");
  else if (!answered)
    tell_error("no element of any dwell is identifiable; the reasons stand with the elements");
  return answered && !doubted ? kDone : kNo;
}

}  // namespace dwell::ctl
