// identify: a recording as text, through the pipeline, as tables or JSON.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/base/printable.hpp"
#include "core/motion/dwell_agreement.hpp"
#include "core/rig/unstated.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/printout.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/motion_report.hpp"

namespace dwell::ctl {
namespace {

// With the last dwell that can be compared and whose data begin within the motion's stretch.
std::optional<Agreement> agreement(const MotionEstimate& motion, const std::vector<Dwell>& dwells) {
  std::optional<Agreement> newest;
  for (const Dwell& dwell : dwells)
    if (answers(dwell) && dwell.settled_s < motion.end_s)
      if (auto with = agreement_of(motion, dwell)) newest = std::move(with);
  return newest;
}

// What any motion holds against the dwells becomes a doubt of theirs, or where it is of little weight a warning.
void object(const MotionEstimate& motion, std::vector<Dwell>& dwells) {
  for (Dwell& dwell : dwells) {
    const std::optional<Objection> objection = objection_to(dwell, motion);
    if (!objection) continue;
    if (objection->grave)
      dwell.doubts.push_back({objection->elements, objection->what});
    else
      dwell.warnings.push_back({WarningKind::any_motion, objection->what, objection->elements, {}});
  }
}

// What ± means. It stands below the dwells' coefficients; where no dwell has any, below those of the motion.
std::string legend(const MotionEstimate& motion, const std::vector<Dwell>& dwells, const Rig& rig) {
  if (std::any_of(dwells.begin(), dwells.end(), [](const Dwell& dwell) { return !legend_of({&dwell}).empty(); }))
    return {};
  Dwell shown;
  shown.elements = motion.elements;
  shown.unstated = unstated_uncertainties(rig);
  std::string text;
  for (const std::string& line : legend_of({&shown})) text += printable(line) + "\n";
  return text;
}

void add(const MotionEstimate& motion, const std::vector<Dwell>& dwells, const Rig& rig, Printout& to) {
  const MotionView view = make_view(motion, agreement(motion, dwells), rig);
  to.document["motion"] = json_value(view);
  if (!motion.reason.empty()) to.document["motion_reason"] = motion.reason;
  to.text.append("\n").append(motion_text(view)).append(legend(motion, dwells, rig));
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

}  // namespace

int identify_recording(const IdentifyOptions& options) {
  const auto run = RecordedRun::load(options.rig, options.data);
  if (!run) return run.error();
  const auto unusable = [](const std::string& why) {
    tell_error(why);
    return kUsage;
  };
  // The dwells are identified for the method of any motion alone too: they tell which readings are at fault.
  std::vector<Dwell> dwells;
  std::vector<ChannelFault> at_fault;
  {
    ProgressBar bar("identifying");
    auto found = identify(run->rig(), run->source(), bar.progress(), nullptr, &at_fault);
    if (!found) return unusable(found.error());
    if (options.method != "motion") dwells = std::move(*found);
  }
  std::optional<MotionEstimate> motion;
  if (options.method != "harmonic") {
    auto found = identify_motion(run->rig(), run->source(), std::move(at_fault));
    if (!found) return unusable(found.error());
    motion = std::move(*found);
    object(*motion, dwells);
  }
  Printout out = printout(run->rig(), run->info(), dwells);
  if (motion) add(*motion, dwells, run->rig(), out);
  print(out, options.json);
  return options.method == "motion" ? judge(*motion) : judge(run->rig(), run->source(), dwells);
}

}  // namespace dwell::ctl
