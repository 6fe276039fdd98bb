#include "daemon/ctl/handon_verbs.hpp"

#include <string>
#include <tuple>

#include "daemon/ctl/options.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/ctl/verbs.hpp"

namespace dwell::ctl {
namespace {

void add_overwrite(CLI::App* verb, bool& overwrite) {
  verb->add_flag("--overwrite", overwrite, "replace files of these names; never a run file or a ledger");
}

}  // namespace

HandonVerbs::HandonVerbs(Verbs& verbs) {
  add_export(verbs);
  add_report(verbs);
}

void HandonVerbs::add_export(Verbs& verbs) {
  CLI::App* const verb =
      verbs.add("export", "a run as csv, hdf5 or uff, or the model of a recording, for other programs",
                [this] { return do_export(); });
  verb->add_option("file", exporting_.file, "the run file; with --model also a recording, CSV, with --rig")->required();
  verb->add_option("-o,--output", exporting_.output, "file that is written; with --model the folder")->required();
  add_overwrite(verb, exporting_.overwrite);
  auto* const format = verb->add_option("--format", exporting_.format,
                                        "csv: t,channel,value, which identify reads; hdf5: instants, values and all "
                                        "attributes; uff: dataset 58, evenly resampled")
                           ->check(CLI::IsMember({"csv", "hdf5", "uff"}));
  auto* const dwell = verb->add_option("--dwell", exporting_.range.dwell,
                                       "only the dwell of this index; with --model: default the last that settled");
  auto* const from = verb->add_option("--from", exporting_.range.from_s, "only from this second of the run on");
  auto* const to = verb->add_option("--to", exporting_.range.to_s, "only up to this second of the run");
  auto* const in_unit = verb->add_flag("--in-unit", exporting_.in_unit,
                                       "csv: adds the columns in_unit and unit; identify refuses such a file");
  auto* const binary = verb->add_flag("--binary", exporting_.binary, "uff: 58b, all bits, less than half the size");
  auto* const unchecked = verb->add_flag("--unchecked", exporting_.unchecked,
                                         "export without an audit, even from a file that is tampered with");
  auto* const key = add_pinned_keys(verb, exporting_.keys);
  auto* const json = add_json(verb, exporting_.json);
  auto* const model = verb->add_flag("--model", model_, "matrices as Matrix Market, a state-space model as JSON");
  auto* const rig = verb->add_option("--rig", model_options_.rig,
                                     "with --model: the rig file of a recording; its devices are not needed");
  rig->needs(model);
  for (CLI::Option* option : {format, from, to, in_unit, binary, unchecked, key, json}) option->excludes(model);
  for (CLI::Option* option : {from, to}) option->excludes(dwell);
  for (CLI::Option* option : {in_unit, binary, unchecked, key, json}) option->needs(format);
  unchecked->excludes(key);
}

void HandonVerbs::add_report(Verbs& verbs) {
  CLI::App* const verb =
      verbs.add("report", "a run as one HTML page for print and archive; exit 1 if it is tampered with",
                [this] { return report(reporting_); });
  verb->add_option("file", reporting_.file, "the run file")->required();
  verb->add_option("-o,--output", reporting_.output, "the page")->required();
  add_overwrite(verb, reporting_.overwrite);
  add_pinned_keys(verb, reporting_.keys);
  add_persons(verb, reporting_.persons);
  add_ledger(verb, reporting_.ledger);
  add_json(verb, reporting_.json);
}

int HandonVerbs::do_export() {
  if (model_) {
    model_options_.data = exporting_.file;
    model_options_.folder = exporting_.output;
    model_options_.overwrite = exporting_.overwrite;
    model_options_.dwell = exporting_.range.dwell;
    return export_model(model_options_);
  }
  if (exporting_.format.empty()) {
    tell_error("export: neither --format nor --model is given; expected --format csv, hdf5 or uff for a run file");
    return kUsage;
  }
  for (const auto& [given, option, format] :
       {std::tuple(exporting_.in_unit, "--in-unit", "csv"), std::tuple(exporting_.binary, "--binary", "uff")})
    if (given && exporting_.format != format) {
      tell_error(std::string("export: ") + option + " belongs to --format " + format +
                 "; expected it without, or that format");
      return kUsage;
    }
  return export_run(exporting_);
}

}  // namespace dwell::ctl
