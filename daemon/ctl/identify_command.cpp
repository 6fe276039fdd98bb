// identify: a recording as text, through the pipeline, as tables or JSON.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "config/rig_file.hpp"
#include "core/motion/dwell_agreement.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/identify.hpp"
#include "daemon/ctl/table_motion.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/dwell_text.hpp"
#include "daemon/report/motion_report.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

void say(const std::string& text) { std::fprintf(stderr, "dwellctl: %s\n", printable(text).c_str()); }

std::string listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

// Why there is nothing to show, in one line.
std::string reason(const Rig& rig, const CsvRecording& recording, const std::vector<Dwell>& dwells) {
  if (dwells.empty()) return why_no_dwell(rig, table_motion(rig, recording));
  for (auto dwell = dwells.rbegin(); dwell != dwells.rend(); ++dwell) {
    if (!dwell->settling_reason.empty()) return "no dwell settled: " + dwell->settling_reason;
    if (!dwell->warnings.empty()) return "no dwell settled: " + dwell->warnings.front();
  }
  return "no dwell settled";
}

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
    say("no coefficients: " + motion.reason);
  else if (!answered)
    say("no element is identifiable; the reasons stand with the elements");
  return answered ? kDone : kNo;
}

int judge(const Rig& rig, const CsvRecording& recording, const std::vector<Dwell>& dwells) {
  const bool settled =
      std::any_of(dwells.begin(), dwells.end(), [](const Dwell& d) { return std::isfinite(d.settled_s); });
  const bool answered = std::any_of(dwells.begin(), dwells.end(), answers);
  const bool doubted = std::any_of(dwells.begin(), dwells.end(), [](const Dwell& d) { return !d.doubts.empty(); });
  if (!settled)
    say(reason(rig, recording, dwells));
  else if (doubted)
    say("there are coefficients that must not be relied on; the reasons stand with the dwell");
  else if (!answered)
    say("no element of any dwell is identifiable; the reasons stand with the elements");
  return answered && !doubted ? kDone : kNo;
}

}  // namespace

int identify_recording(const IdentifyOptions& options) {
  const auto file = config::load(options.rig, {});
  if (!file) {
    std::fputs(config::to_string(options.rig, file.error()).c_str(), stderr);
    return kUsage;
  }
  if (file->rig.excitation.reference == Reference::sync) {
    say(options.rig + ": the reference is \"sync\", and a recording as text holds no pulses: expected \"tracked\" or " +
        "\"fixed\" there");
    return kUsage;
  }
  const auto recording = read_csv(options.data);
  if (!recording) {
    say(recording.error());
    return kUsage;
  }
  const ColumnMatch match = match_columns(file->rig, *recording);
  if (!match.missing_channels.empty()) {
    say(options.data + ": no column for " + listed(match.missing_channels) + "; there are " +
        listed(recording->channels));
    return kUsage;
  }
  if (!match.unknown_columns.empty()) {
    say("warning: " + options.data + ": the rig has no channel " + listed(match.unknown_columns) + "; ignored");
  }

  Progress progress;
  if (isatty(STDERR_FILENO) != 0 && recording->samples.size() > 2'000'000) {
    progress = [](double part) { std::fprintf(stderr, part < 1.0 ? "\r%3.0f %%" : "\r     \r", 100.0 * part); };
  }
  std::vector<Dwell> dwells;
  if (options.method != "motion") dwells = identify(file->rig, *recording, progress);
  std::optional<MotionEstimate> motion;
  if (options.method != "harmonic") motion = identify_motion(file->rig, *recording);

  print(options, *file, dwells, motion);
  return options.method == "motion" ? judge(*motion) : judge(file->rig, *recording, dwells);
}

}  // namespace dwell::ctl
