// verify: a recording identified, and its model held against the transients that the coefficients never saw.
// export --model: the model's files.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/base/instants.hpp"
#include "core/verify/verification.hpp"
#include "core/verify/verification_causes.hpp"
#include "core/verify/verification_readings.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/handon/output_file.hpp"
#include "daemon/report/model_files.hpp"
#include "daemon/report/number_text.hpp"
#include "daemon/report/verification_json.hpp"
#include "daemon/report/verification_text.hpp"

namespace dwell::ctl {
namespace {

struct VerifiedDwell {
  Dwell dwell;
  Verification verification;
};

// The end of the settled dwell before this one. The motion of this one begins there.
std::int64_t end_before(const std::vector<Dwell>& dwells, const Dwell& of) {
  std::int64_t end_ns = INT64_MIN;
  for (const Dwell& dwell : dwells)
    if (std::isfinite(dwell.settled_s) && dwell.index < of.index) end_ns = std::max(end_ns, to_ns(dwell.end_s));
  return end_ns;
}

// The dwell asked for, by its index; none: the last that settled. The error: an exit code.
tl::expected<VerifiedDwell, int> verified(const RecordedRun& run, std::optional<int> index) {
  VerificationReadings readings(run.rig().channels.size());
  const auto found_dwells = [&] {
    ProgressBar bar("identifying");
    return identify(run.rig(), run.source(), bar.progress(), &readings);
  }();
  if (!found_dwells) {
    tell_error(found_dwells.error());
    return tl::make_unexpected(kUsage);
  }
  const std::vector<Dwell>& dwells = *found_dwells;
  const auto asked = [&](const Dwell& dwell) { return index ? dwell.index == index : std::isfinite(dwell.settled_s); };
  const auto found = std::find_if(dwells.rbegin(), dwells.rend(), asked);
  if (found == dwells.rend()) {
    tell_error(index ? "the recording has no dwell " + std::to_string(*index) + "; there are " +
                           std::to_string(dwells.size())
                     : why_nothing_settled(run.rig(), run.source(), dwells));
    return tl::make_unexpected(index ? kUsage : kNo);
  }
  const Rig& rig = run.rig();
  std::vector<OtherDwell> others;
  for (const Dwell& dwell : dwells)
    if (std::isfinite(dwell.settled_s) && dwell.index != found->index)
      others.push_back({dwell, readings.between(end_before(dwells, dwell), to_ns(dwell.end_s))});
  const std::vector<ChannelReadings> before = readings.since(end_before(dwells, *found));
  VerifiedDwell out{*found, verify_model(rig, *found, before, run.file().verification.accuracy, others)};
  if (asks_for_causes(out.verification, out.dwell))
    tell_causes(find_causes(rig, before, to_ns(found->verdict_s)), out.verification);
  return out;
}

handon::Target target_of(const ExportOptions& options, const ModelFile& file) {
  return {(std::filesystem::path(options.folder) / file.name).string(), options.overwrite};
}

record::Result<void> write(const ExportOptions& options, const std::vector<ModelFile>& files) {
  // All or none, as far as can be known before.
  for (const ModelFile& file : files)
    if (auto may = handon::may_write(target_of(options, file)); !may) return may;
  for (const ModelFile& file : files) {
    auto output = handon::OutputFile::create(target_of(options, file));
    if (!output) return tl::make_unexpected(output.error());
    output->write(file.text);
    if (auto kept = output->keep(); !kept) return kept;
  }
  return {};
}

}  // namespace

int verify_recording(const VerifyOptions& options) {
  const auto run = RecordedRun::load(options.rig, options.data);
  if (!run) return run.error();
  const auto seen = verified(*run, options.dwell);
  if (!seen) return seen.error();
  const Rig& rig = run->rig();
  const std::string text = options.json ? dump(json_value(seen->verification, rig, seen->dwell), 2) + "\n"
                                        : verification_text(make_view(seen->verification, rig, seen->dwell));
  std::fwrite(text.data(), 1, text.size(), stdout);
  return seen->verification.verdict == Verdict::adequate ? kDone : kNo;
}

int export_model(const ExportOptions& options) {
  const auto run = RecordedRun::load(options.rig, options.data);
  if (!run) return run.error();
  const auto seen = verified(*run, options.dwell);
  if (!seen) return seen.error();
  const auto files = model_files(run->rig(), run->info(), seen->dwell, seen->verification);
  if (!files) {
    tell_error(files.error());
    return kNo;
  }
  std::error_code failed;
  std::filesystem::create_directories(options.folder, failed);
  if (auto done = write(options, *files); !done) {
    tell_error(done.error());
    return kUsage;
  }
  if (seen->verification.verdict != Verdict::adequate)
    tell_error(std::string("the model is ") + to_string(seen->verification.verdict) + "; model.json says why");
  return kDone;
}

}  // namespace dwell::ctl
