#include "daemon/ctl/recorded_run.hpp"

#include <cstdio>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/run_source.hpp"
#include "daemon/ctl/table_motion.hpp"
#include "daemon/record/regular_file.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

std::string names_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

tl::unexpected<int> unusable(const std::string& why) {
  tell_error(why);
  return tl::unexpected<int>(kUsage);
}

tl::expected<std::unique_ptr<const config::RigFile>, int> load_rig(const std::string& path) {
  auto file = config::load(path, {});
  if (file) return std::make_unique<const config::RigFile>(std::move(*file));
  std::fputs(config::to_string(path, file.error()).c_str(), stderr);
  return tl::make_unexpected(kUsage);
}

}  // namespace

void tell_error(const std::string& text) {
  constexpr std::size_t kMost = 4000;  // a hostile file may put megabytes into a message
  std::fprintf(stderr, "dwellctl: %s%s\n", printable(text.substr(0, kMost)).c_str(), text.size() > kMost ? " …" : "");
}

tl::expected<RecordedRun, int> RecordedRun::load(const std::string& rig, const std::string& data) {
  if (const auto file = record::open_regular(data); !file) return unusable(file.error());
  return is_run_file(data) ? from_run_file(rig, data) : from_csv(rig, data);
}

tl::expected<RecordedRun, int> RecordedRun::from_csv(const std::string& rig, const std::string& data) {
  if (rig.empty()) {
    tell_error(data + " is no run file; a recording as text needs its rig file: --rig RIG.toml");
    return tl::make_unexpected(kUsage);
  }
  auto file = load_rig(rig);
  if (!file) return tl::make_unexpected(file.error());
  if ((*file)->rig.excitation.reference == Reference::sync) {
    tell_error(rig + ": the reference is \"sync\", and a recording as text holds no pulses: expected \"tracked\" or " +
               "\"fixed\" there");
    return tl::make_unexpected(kUsage);
  }
  auto recording = read_csv(data);
  if (!recording) return unusable(recording.error());
  const ColumnMatch match = match_columns((*file)->rig, *recording);
  if (!match.missing_channels.empty()) {
    tell_error(data + ": no column for " + names_of(match.missing_channels) + "; there are " +
               names_of(recording->channels));
    return tl::make_unexpected(kUsage);
  }
  if (!match.unknown_columns.empty()) {
    tell_error("warning: " + data + ": the rig has no channel " + names_of(match.unknown_columns) + "; ignored");
  }
  auto source = std::make_unique<const CsvSource>((*file)->rig, std::move(*recording));
  RunInfo info{(*file)->sha256, DWELL_VERSION, ""};
  return RecordedRun(std::move(*file), std::move(source), std::move(info));
}

tl::expected<RecordedRun, int> RecordedRun::from_run_file(const std::string& rig, const std::string& data) {
  auto reader = record::RunReader::open(data);
  if (!reader) return unusable(reader.error());
  const record::RunHeader& header = reader->header();
  if (header.is_child()) return unusable(why_no_stream(data, header));
  std::unique_ptr<const config::RigFile> file;
  if (rig.empty()) {
    auto own = rig_of(header, data);
    if (!own) return unusable(own.error());
    file = std::make_unique<const config::RigFile>(std::move(*own));
  } else {
    auto other = load_rig(rig);
    if (!other) return tl::make_unexpected(other.error());
    file = std::move(*other);
  }
  auto channels = ChannelMap::between(header, data, file->rig, rig.empty() ? header.rig.path : rig);
  if (!channels) return unusable(channels.error());
  RunInfo info{file->sha256, DWELL_VERSION, header.start_utc};
  auto source = std::make_unique<const RunSource>(std::move(*reader), std::move(*channels));
  return RecordedRun(std::move(file), std::move(source), std::move(info));
}

std::string why_nothing_settled(const Rig& rig, const RecordSource& source, const std::vector<Dwell>& dwells) {
  if (dwells.empty()) return why_no_dwell(rig, table_motion(rig, source));
  for (auto dwell = dwells.rbegin(); dwell != dwells.rend(); ++dwell) {
    if (!dwell->settling_reason.empty()) return "no dwell settled: " + dwell->settling_reason;
    if (!dwell->warnings.empty()) return "no dwell settled: " + dwell->warnings.front().what;
  }
  return "no dwell settled";
}

}  // namespace dwell::ctl
