// identify: a recording as text, through the pipeline, as tables or JSON.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

// Whether some coefficient may be taken from it.
bool answers(const Dwell& dwell) {
  return std::isfinite(dwell.settled_s) && dwell.doubts.empty() &&
         std::any_of(dwell.elements.begin(), dwell.elements.end(),
                     [](const ElementEstimate& e) { return e.identifiable; });
}

}  // namespace

int identify_recording(const IdentifyOptions& options) {
  const auto loaded = load_recorded_run(options.rig, options.data);
  if (!loaded) return loaded.error();
  const auto& [file, recording] = *loaded;
  const std::vector<Dwell> dwells = identify(file.rig, recording, progress_of(recording));

  const RunInfo run{file.sha256, DWELL_VERSION, ""};
  Json document = {{"rig", file.rig.name}, {"dwells", Json::array()}};
  std::string text = "rig " + printable(file.rig.name) + "\n";
  for (const Dwell& dwell : dwells) {
    const DwellView view = make_view(dwell, file.rig, run);
    if (options.json) {
      document["dwells"].push_back(json_value(view));
    } else {
      text.append("\n").append(dwell_text(view));
    }
  }
  if (options.json) text = dump(document, 2) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);

  const bool settled =
      std::any_of(dwells.begin(), dwells.end(), [](const Dwell& d) { return std::isfinite(d.settled_s); });
  const bool answered = std::any_of(dwells.begin(), dwells.end(), answers);
  const bool doubted = std::any_of(dwells.begin(), dwells.end(), [](const Dwell& d) { return !d.doubts.empty(); });
  if (!settled)
    complain(why_nothing_settled(file.rig, recording, dwells));
  else if (doubted)
    complain("there are coefficients that must not be relied on; the reasons stand with the dwell");
  else if (!answered)
    complain("no element of any dwell is identifiable; the reasons stand with the elements");
  return answered && !doubted ? kDone : kNo;
}

}  // namespace dwell::ctl
