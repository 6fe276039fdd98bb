#include "daemon/ctl/recorded_run.hpp"

#include <cstdio>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/table_motion.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

std::string names_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

}  // namespace

void tell_error(const std::string& text) { std::fprintf(stderr, "dwellctl: %s\n", printable(text).c_str()); }

tl::expected<RecordedRun, int> load_recorded_run(const std::string& rig, const std::string& data) {
  auto file = config::load(rig, {});
  if (!file) {
    std::fputs(config::to_string(rig, file.error()).c_str(), stderr);
    return tl::make_unexpected(kUsage);
  }
  if (file->rig.excitation.reference == Reference::sync) {
    tell_error(rig + ": the reference is \"sync\", and a recording as text holds no pulses: expected \"tracked\" or " +
               "\"fixed\" there");
    return tl::make_unexpected(kUsage);
  }
  auto recording = read_csv(data);
  if (!recording) {
    tell_error(recording.error());
    return tl::make_unexpected(kUsage);
  }
  const ColumnMatch match = match_columns(file->rig, *recording);
  if (!match.missing_channels.empty()) {
    tell_error(data + ": no column for " + names_of(match.missing_channels) + "; there are " +
               names_of(recording->channels));
    return tl::make_unexpected(kUsage);
  }
  if (!match.unknown_columns.empty()) {
    tell_error("warning: " + data + ": the rig has no channel " + names_of(match.unknown_columns) + "; ignored");
  }
  return RecordedRun{std::move(*file), std::move(*recording)};
}

std::string why_nothing_settled(const Rig& rig, const CsvRecording& recording, const std::vector<Dwell>& dwells) {
  if (dwells.empty()) return why_no_dwell(rig, table_motion(rig, recording));
  for (auto dwell = dwells.rbegin(); dwell != dwells.rend(); ++dwell) {
    if (!dwell->settling_reason.empty()) return "no dwell settled: " + dwell->settling_reason;
    if (!dwell->warnings.empty()) return "no dwell settled: " + dwell->warnings.front();
  }
  return "no dwell settled";
}

}  // namespace dwell::ctl
