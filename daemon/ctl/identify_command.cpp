// identify: a recording as text, through the pipeline, as tables or JSON.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "core/motion/dwell_agreement.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/motion_report.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

// Whether some coefficient may be taken from it.
bool answers(const Dwell& dwell) {
  return std::isfinite(dwell.settled_s) && dwell.doubts.empty() &&
         std::any_of(dwell.elements.begin(), dwell.elements.end(),
                     [](const ElementEstimate& e) { return e.identifiable; });
}

// Of the dwells whose data lie within the motion's stretch the last; NaN: there is none that has coefficients.
double agreement(const MotionEstimate& motion, const std::vector<Dwell>& dwells) {
  double e_n = kNaN;
  for (const Dwell& dwell : dwells)
    if (answers(dwell) && dwell.settled_s < motion.end_s)
      if (const double of = agreement_e_n(motion, dwell); std::isfinite(of)) e_n = of;
  return e_n;
}

void print(const IdentifyOptions& options, const config::RigFile& file, const std::vector<Dwell>& dwells,
           const std::optional<MotionEstimate>& motion) {
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
  if (motion) {
    const MotionView view = make_view(*motion, agreement(*motion, dwells), file.rig);
    document["motion"] = json_value(view);
    if (!motion->reason.empty()) document["motion_reason"] = motion->reason;
    text.append("\n").append(motion_text(view));
  }
  if (options.json) text = dump(document, 2) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
}

int judge(const MotionEstimate& motion) {
  const bool answered = std::any_of(motion.elements.begin(), motion.elements.end(),
                                    [](const ElementEstimate& e) { return e.identifiable; });
  if (!motion.reason.empty())
    tell_error("no coefficients: " + motion.reason);
  else if (!answered)
    tell_error("no element is identifiable; the reasons stand with the elements");
  return answered ? kDone : kNo;
}

int judge(const Rig& rig, const CsvRecording& recording, const std::vector<Dwell>& dwells) {
  const bool settled =
      std::any_of(dwells.begin(), dwells.end(), [](const Dwell& d) { return std::isfinite(d.settled_s); });
  const bool answered = std::any_of(dwells.begin(), dwells.end(), answers);
  const bool doubted = std::any_of(dwells.begin(), dwells.end(), [](const Dwell& d) { return !d.doubts.empty(); });
  if (!settled)
    tell_error(why_nothing_settled(rig, recording, dwells));
  else if (doubted)
    tell_error("there are coefficients that must not be relied on; the reasons stand with the dwell");
  else if (!answered)
    tell_error("no element of any dwell is identifiable; the reasons stand with the elements");
  return answered && !doubted ? kDone : kNo;
}

}  // namespace

int identify_recording(const IdentifyOptions& options) {
  const auto loaded = load_recorded_run(options.rig, options.data);
  if (!loaded) return loaded.error();
  const auto& [file, recording] = *loaded;
  std::vector<Dwell> dwells;
  if (options.method != "motion") {
    ProgressBar bar("identifying");
    dwells = identify(file.rig, recording, bar.progress());
  }
  std::optional<MotionEstimate> motion;
  if (options.method != "harmonic") motion = identify_motion(file.rig, recording);
  print(options, file, dwells, motion);
  return options.method == "motion" ? judge(*motion) : judge(file.rig, recording, dwells);
}

}  // namespace dwell::ctl
