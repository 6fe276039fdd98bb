#include "daemon/ctl/record_verbs.hpp"

#include "daemon/ctl/options.hpp"
#include "daemon/ctl/verbs.hpp"

namespace dwell::ctl {

RecordVerbs::RecordVerbs(Verbs& verbs, Service& service) {
  CLI::App* const audit =
      verbs.add("audit", "whether run files are as they were recorded; exit 1 if one is tampered with", [this] {
        auditing_.ledger_beside = ledger_->count() > 0 && auditing_.ledger.empty();
        return audit_files(auditing_);
      });
  audit->add_option("files", auditing_.files, "run files");
  ledger_ = add_ledger(audit, auditing_.ledger)->expected(0, 1);
  add_pinned_keys(audit, auditing_.keys);
  add_persons(audit, auditing_.persons);
  audit->add_option("--anchor", auditing_.anchors, "files with anchors: heads that were kept elsewhere");
  audit->add_flag("--every-signature", auditing_.every_signature,
                  "verify each note's signature by itself; slower, and finds nothing else: the newest covers all");
  audit->add_flag("--closed", auditing_.closed, "a file that has no end counts as a failure: exit 1");
  add_json(audit, auditing_.json);

  CLI::App* const list = verbs.add("runs", "the recorded runs of the service, or those in a folder",
                                   [&service, this] { return runs(service, folder_); });
  list->add_option("directory", folder_, "a folder of run files; without one the service is asked");
  add_service(list, service);

  CLI::App* const show = verbs.add("show", "what a run was: rig, times, dwells, events, signatures",
                                   [&service, this] { return show_run(file_, service.json); });
  show->add_option("file", file_, "the run file")->required();
  add_json(show, service.json);

  CLI::App* const sign = verbs.add("sign", "your signature under a run that has ended",
                                   [&service, this] { return ctl::sign(service, signing_); });
  sign->add_option("file", signing_.file, "the run file")->required();
  auto* const meaning = add_text(sign, "--meaning", signing_.meaning, record::kLabelBytes,
                                 "what the signature says, for instance \"reviewed\"");
  add_text(sign, "--name", signing_.name, record::kLabelBytes, "your name; default: as the system knows you");
  add_text(sign, "--reason", signing_.reason, record::kCommentBytes, "why");
  sign->add_option("--key", signing_.key, "sign with this private key of your own; default: the service vouches");
  sign->add_flag("--enter", signing_.enter,
                 "sign nothing: the service enters into its ledger the signatures that it does not know yet")
      ->excludes(meaning);
  add_control(sign, service);
  add_json(sign, service.json);

  CLI::App* const keygen =
      verbs.add("keygen", "make a key of your own, to sign runs with", [this] { return make_key(key_); });
  keygen->add_option("--key", key_.file, "file of the private key; default: ~/.config/dwell/key");
  keygen->add_option("--name", key_.name, "the key's name; default: USER@HOST");
  add_json(keygen, key_.json);
}

}  // namespace dwell::ctl
