#include "daemon/ctl/handon_commands.hpp"

#include <array>
#include <chrono>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <optional>
#include <utility>

#include "daemon/ctl/half_written.hpp"
#include "daemon/ctl/pinned_key.hpp"
#include "daemon/ctl/progress.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/ctl/run_source.hpp"
#include "daemon/handon/csv.hpp"
#include "daemon/handon/hdf5.hpp"
#include "daemon/handon/output_file.hpp"
#include "daemon/handon/report.hpp"
#include "daemon/handon/resampler.hpp"
#include "daemon/handon/uff.hpp"
#include "daemon/record/audit.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

using handon::Provenance;
using handon::Result;
using handon::Selection;

std::string utc_now() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text.data();
}

Provenance provenance() { return {"dwellctl " DWELL_VERSION, utc_now(), "", "not audited"}; }

Result<record::Audit> audited(const std::string& file, const std::vector<std::string>& keys,
                              const std::vector<std::string>& persons, const std::string& ledger) {
  record::AuditOptions options;
  for (const auto& [asked, to] : {std::pair(&keys, &options.keys), std::pair(&persons, &options.persons)}) {
    auto pinned = pinned_keys(*asked);
    if (!pinned) return tl::make_unexpected(pinned.error());
    *to = std::move(*pinned);
  }
  options.ledger = ledger;
  ProgressBar bar("checking");
  options.progress = bar.progress();
  return record::audit_run(file, options);
}

bool same_file(const std::string& a, const std::string& b) {
  std::error_code none;
  return std::filesystem::equivalent(a, b, none);
}

// What was written, for people and for programs.
struct Written {
  std::uint64_t samples = 0;
  bool empty = false;  // no reading is in the file
  std::string more;    // "; 3 datasets of …"
  Json json = Json::object();
};

handon::Target target_of(const ExportRunOptions& options) { return {options.output, options.overwrite}; }

// "run.csv" -> "run.rig.toml".
std::string rig_path(const std::string& csv) {
  std::filesystem::path path(csv);
  if (path.extension() == ".csv") path.replace_extension();
  return path.string() + ".rig.toml";
}

Result<void> write_rig(const Selection& selection, const handon::Target& target) {
  auto file = handon::OutputFile::create(target);
  if (!file) return tl::make_unexpected(file.error());
  file->write(selection.header().rig.text);
  return file->keep();
}

Result<Written> write_csv(Selection& selection, const Provenance& from, const ExportRunOptions& options,
                          const Progress& progress) {
  // Asked before the samples are written, so that both files are written or none.
  const std::string rig = rig_path(options.output);
  if (auto may = handon::may_write({rig, options.overwrite}); !may) return tl::make_unexpected(may.error());
  const auto count = handon::export_csv(selection, from, {options.in_unit}, target_of(options), progress);
  if (!count) return tl::make_unexpected(count.error());
  if (auto done = write_rig(selection, {rig, options.overwrite}); !done) return tl::make_unexpected(done.error());
  return Written{*count, *count == 0, "; the rig file: " + rig, {{"rig_file", rig}}};
}

Result<Written> write_hdf5(Selection& selection, const Provenance& from, const ExportRunOptions& options,
                           const Progress& progress) {
  const auto count = handon::export_hdf5(selection, from, target_of(options), progress);
  if (!count) return tl::make_unexpected(count.error());
  return Written{*count, *count == 0, "", Json::object()};
}

Result<Written> write_uff(Selection& selection, const Provenance& from, const ExportRunOptions& options,
                          const Progress& progress) {
  const auto done = handon::export_uff(selection, from, {options.binary}, target_of(options), progress);
  if (!done) return tl::make_unexpected(done.error());
  Written written{
      done->samples,
      done->datasets == 0,
      "; " + std::to_string(done->values) + " even values in " + std::to_string(done->datasets) + " datasets",
      {{"values", done->values}, {"datasets", done->datasets}, {"left_out", done->left_out}}};
  if (done->left_out > 0)
    written.more += "; " + std::to_string(done->left_out) +
                    " samples left out: the stretches between gaps are too short to resample, below " +
                    std::to_string(handon::Resampler::kFewest) + " readings";
  return written;
}

// Throws AskedToEnd.
Result<Written> write(Selection& selection, const Provenance& from, const ExportRunOptions& options) {
  ProgressBar bar("exporting");
  const Progress progress = [&bar](double part) {
    HalfWritten::check();
    bar.show(part);
  };
  if (options.format == "csv") return write_csv(selection, from, options, progress);
  if (options.format == "hdf5") return write_hdf5(selection, from, options, progress);
  return write_uff(selection, from, options, progress);
}

void tell(const ExportRunOptions& options, const Written& written, const Provenance& from) {
  if (options.json) {
    Json object = {{"file", options.output}, {"format", options.format}, {"samples", written.samples}};
    object.update(written.json);
    object["audit"] = from.audit;
    std::printf("%s\n", dump(object, 2).c_str());
    return;
  }
  std::printf("%s: %llu samples%s\n", printable(options.output).c_str(),
              static_cast<unsigned long long>(written.samples), printable(written.more).c_str());
}

// Ends the program where it was asked to end meanwhile.
Result<Written> write_or_end(Selection& selection, const Provenance& from, const ExportRunOptions& options) {
  const HalfWritten half_written;
  try {
    auto written = write(selection, from, options);
    HalfWritten::check();
    return written;
  } catch (const AskedToEnd& asked) {
    end_by(asked);
  }
}

}  // namespace

int export_run(const ExportRunOptions& options) {
  if (same_file(options.file, options.output)) {
    tell_error(options.output + ": is the run file itself; expected another file");
    return kUsage;
  }
  // Asked now as well: an audit may take minutes.
  if (auto may = handon::may_write(target_of(options)); !may) {
    tell_error(may.error());
    return kUsage;
  }
  Provenance from = provenance();
  if (!options.unchecked) {
    const auto audit = audited(options.file, options.keys, {}, "");
    if (!audit) {
      tell_error(audit.error());
      return kUsage;
    }
    from.head = audit->head;
    from.audit = handon::audit_line(*audit);
    if (audit->state == record::AuditState::tampered) {
      const std::string refused = options.file + ": " + from.audit + "; nothing was exported";
      const bool readable = Selection::open(options.file, {}).has_value();
      tell_error(refused +
                 (readable ? ". --unchecked exports it without an audit" : ", and it cannot be read as a run"));
      return is_run_file(options.file) ? kNo : kUsage;
    }
  }
  auto selection = Selection::open(options.file, options.range);
  if (!selection) {
    tell_error(selection.error());
    return kUsage;
  }
  if (selection->header().is_child()) {
    tell_error(why_no_stream(options.file, selection->header()));
    return kUsage;
  }
  const auto written = write_or_end(*selection, from, options);
  if (!written) {
    tell_error(written.error());
    return kUsage;
  }
  tell(options, *written, from);
  if (!written->empty) return kDone;
  tell_error(options.output + ": holds no readings, for the run or the range asked for has none" +
             (options.format == "uff" ? " that can be resampled" : ""));
  return kNo;
}

int report(const ReportOptions& options) {
  if (same_file(options.file, options.output)) {
    tell_error(options.output + ": is the run file itself; expected another file");
    return kUsage;
  }
  if (auto may = handon::may_write({options.output, options.overwrite}); !may) {
    tell_error(may.error());
    return kUsage;
  }
  const auto audit = audited(options.file, options.keys, options.persons, options.ledger);
  if (!audit) {
    tell_error(audit.error());
    return kUsage;
  }
  const bool tampered = audit->state == record::AuditState::tampered;
  auto selection = Selection::open_damaged(options.file);
  if (!selection) {
    tell_error(tampered ? options.file + ": " + handon::audit_line(*audit) + "; no page: it cannot be read as a run"
                        : selection.error());
    return tampered && is_run_file(options.file) ? kNo : kUsage;
  }
  Provenance from = provenance();
  from.head = audit->head;
  from.audit = handon::audit_line(*audit);
  ProgressBar bar("reading");
  const auto unreadable =
      handon::export_report(*selection, *audit, from, {options.output, options.overwrite}, bar.progress());
  if (!unreadable) {
    tell_error(unreadable.error());
    return kUsage;
  }
  for (const std::string& why : *unreadable) tell_error(why);
  if (options.json) {
    const Json object{{"file", options.output}, {"audit", from.audit}, {"unreadable", *unreadable}};
    std::printf("%s\n", dump(object, 2).c_str());
  } else {
    std::printf("%s: the file is %s\n", printable(options.output).c_str(), printable(from.audit).c_str());
  }
  if (tampered || !audit->broken_ledger.empty()) return kNo;
  return unreadable->empty() ? kDone : kUsage;
}

}  // namespace dwell::ctl
