// dwellctl: from the command line to the verbs of commands.hpp.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/handon_verbs.hpp"
#include "daemon/ctl/options.hpp"

namespace {

using namespace dwell::ctl;

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 the answer is no, 2 wrong usage or unusable input, 3 the service cannot be reached.";

constexpr const char* kRigHelp =
    "the rig file; its devices are not needed. For a run file: another rig file than its own";
constexpr const char* kDataHelp = "a run file, or a recording as CSV: t,NAME,… or t,channel,value";

void add_service(CLI::App* verb, Service& service) {
  verb->add_option("--url", service.url, "address of the service's HTTP interface")
      ->envname("DWELL_URL")
      ->capture_default_str();
  verb->add_option("--token-file", service.token_file,
                   "holds the token that the service asks for from another computer")
      ->envname("DWELL_TOKEN_FILE");
  add_json(verb, service.json);
}

void add_control(CLI::App* verb, Service& service) {
  verb->add_option("--control", service.control, "the service's control socket")
      ->envname("DWELL_CONTROL")
      ->capture_default_str();
}

// The verbs that look at run files and sign them.
class RecordVerbs {
 public:
  // service: what `runs` and `sign` ask; outlives this.
  RecordVerbs(CLI::App& app, Service& service) : service_(service) {
    audit_ = app.add_subcommand("audit", "whether run files are as they were recorded; exit 1 if one is tampered with");
    audit_->add_option("files", auditing_.files, "run files");
    add_ledger(audit_, auditing_.ledger);
    add_pinned_keys(audit_, auditing_.keys);
    add_persons(audit_, auditing_.persons);
    audit_->add_option("--anchor", auditing_.anchors, "files with anchors: heads that were kept elsewhere");
    audit_->add_flag("--every-signature", auditing_.every_signature,
                     "verify each note's signature by itself; slower, and finds nothing else: the newest covers all");
    audit_->add_flag("--closed", auditing_.closed, "a file that has no end counts as a failure: exit 1");
    add_json(audit_, auditing_.json);

    runs_ = app.add_subcommand("runs", "the recorded runs of the service, or those in a folder");
    runs_->add_option("directory", folder_, "a folder of run files; without one the service is asked");
    add_service(runs_, service);

    show_ = app.add_subcommand("show", "what a run was: rig, times, dwells, events, signatures");
    show_->add_option("file", file_, "the run file")->required();
    add_json(show_, service.json);

    sign_ = app.add_subcommand("sign", "your signature under a run that has ended");
    sign_->add_option("file", signing_.file, "the run file")->required();
    auto* const meaning =
        add_text(sign_, "--meaning", signing_.meaning, "what the signature says, for instance \"reviewed\"");
    add_text(sign_, "--name", signing_.name, "your name; default: as the system knows you");
    add_text(sign_, "--reason", signing_.reason, "why");
    sign_->add_option("--key", signing_.key, "sign with this private key of your own; default: the service vouches");
    sign_
        ->add_flag("--enter", signing_.enter,
                   "sign nothing: the service enters into its ledger which persons' own keys have signed the file")
        ->excludes(meaning);
    add_control(sign_, service);
    add_json(sign_, service.json);

    keygen_ = app.add_subcommand("keygen", "make a key of your own, to sign runs with");
    keygen_->add_option("--key", key_.file, "file of the private key; default: ~/.config/dwell/key");
    keygen_->add_option("--name", key_.name, "the key's name; default: USER@HOST");
    add_json(keygen_, key_.json);
  }

  // Does the verb of the command line and returns its exit code; nullopt: it is another one.
  [[nodiscard]] std::optional<int> run() const {
    if (*audit_) return audit_files(auditing_);
    if (*runs_) return runs(service_, folder_);
    if (*show_) return show_run(file_, service_.json);
    if (*sign_) return sign(service_, signing_);
    if (*keygen_) return make_key(key_);
    return std::nullopt;
  }

 private:
  const Service& service_;
  AuditRequest auditing_;
  SignOptions signing_;
  KeyOptions key_;
  std::string folder_, file_;
  CLI::App *audit_, *runs_, *show_, *sign_, *keygen_;
};

int run(int argc, char** argv) {
  CLI::App app("Asks the dwell service, and identifies stiffness and damping from recordings.", "dwellctl");
  app.set_version_flag("--version", DWELL_VERSION);
  app.require_subcommand(1);
  app.footer(kExitCodes);

  Service service;
  service.url = "http://127.0.0.1:8380";
  service.control = "/run/dwell/control";
  WatchOptions watching;
  IdentifyOptions identifying;
  std::string rig;

  CLI::App* status_verb =
      app.add_subcommand("status", "the current dwell; exit 1 if it is not measuring or not to be relied on");
  add_service(status_verb, service);

  CLI::App* watch_verb = app.add_subcommand("watch", "the current dwell, refreshed until q or Ctrl-C");
  add_service(watch_verb, service);
  add_control(watch_verb, service);
  watch_verb->add_option("--interval", watching.interval_s, "s between refreshes")->check(CLI::Range(0.01, 3600.0));
  watch_verb->add_option("--until", watching.until_s, "end once a settled dwell has so many seconds of data")
      ->check(CLI::Range(0.0, 1e9));
  watch_verb->add_option("--limit", watching.limit_s, "give up, with exit 1, after so many seconds")
      ->check(CLI::Range(0.0, 1e9));
  watch_verb->add_option("--truth", watching.truth,
                         "JSON file with the coefficients of a simulated rig, shown beside the measured ones; with "
                         "--until, exit 1 if one is off by more than 4 standard uncertainties");

  CLI::App* channels_verb = app.add_subcommand("channels", "every channel: value, status, rate, counts");
  add_service(channels_verb, service);

  CLI::App* dwells_verb = app.add_subcommand("dwells", "the dwells that have been completed");
  add_service(dwells_verb, service);

  std::string label, comment;
  const auto add_comment = [&comment](CLI::App* verb) {
    add_text(verb, "--comment", comment, "why, for the record; at most 4000 bytes");
  };
  CLI::App* start_verb = app.add_subcommand(
      "start", "begin a recorded run now; exit 1 if an operator's run goes on already, or if nothing is recorded");
  add_text(start_verb, "--label", label, "what the run is; at most 200 bytes")->required();
  add_comment(start_verb);
  add_control(start_verb, service);
  add_json(start_verb, service.json);

  CLI::App* stop_verb = app.add_subcommand("stop", "end the recorded run now; exit 1 if none goes on");
  add_comment(stop_verb);
  add_control(stop_verb, service);
  add_json(stop_verb, service.json);

  CLI::App* rearm_verb = app.add_subcommand("rearm", "end the dwell here and settle anew");
  add_comment(rearm_verb);
  add_control(rearm_verb, service);
  add_json(rearm_verb, service.json);

  CLI::App* alarms_verb = app.add_subcommand("alarms", "what is wrong and lasts; exit 1 if there is anything");
  add_service(alarms_verb, service);

  std::vector<std::string> alarm_names;
  CLI::App* acknowledge_verb =
      app.add_subcommand("acknowledge", "say that you know of an alarm; exit 1 if there is none of that name");
  acknowledge_verb->add_option("alarm", alarm_names, "names, as in the list of alarms")->required();
  add_comment(acknowledge_verb);
  add_control(acknowledge_verb, service);
  add_json(acknowledge_verb, service.json);

  CLI::App* check_verb =
      app.add_subcommand("check", "each device probed once; exit 1 if a channel does not answer or is gated");
  check_verb->add_option("--rig", rig, "probe the devices of this rig file, without the service");
  add_control(check_verb, service);
  add_json(check_verb, service.json);

  CLI::App* identify_verb = app.add_subcommand("identify", "coefficients from a recording; exit 1 if no dwell settled");
  identify_verb->add_option("--rig", identifying.rig, kRigHelp);
  identify_verb->add_option("data", identifying.data, kDataHelp)->required();
  identify_verb
      ->add_option("--method", identifying.method,
                   "harmonic: steady dwells; motion: maximum likelihood on any motion; both (default)")
      ->check(CLI::IsMember({"harmonic", "motion", "both"}));
  add_json(identify_verb, identifying.json);

  ReplayOptions replaying;
  CLI::App* replay_verb =
      app.add_subcommand("replay", "a run computed again from its stream; exit 1 if that differs from what was stored");
  replay_verb->add_option("file", replaying.file, "the run file")->required();
  CLI::Option* const replay_rig = replay_verb->add_option(
      "--rig", replaying.rig,
      "compute with this rig file instead, and compare nothing; it must have the run's channels");
  CLI::Option* const child =
      replay_verb->add_option("-o,--output", replaying.output, "the child file to write")->needs(replay_rig);
  replay_verb
      ->add_option("--against", replaying.against,
                   "a child file of this run: compute with its rig file, and compare with its results")
      ->excludes(replay_rig);
  add_text(replay_verb, "--comment", replaying.comment, "why, into the child file")->needs(child);
  replay_verb
      ->add_option("--key", replaying.key, "file of the private key that signs the child file; default: your own")
      ->needs(child);
  add_json(replay_verb, replaying.json);

  VerifyOptions verifying;
  CLI::App* verify_verb = app.add_subcommand(
      "verify", "the model against transients it never saw, live or of a recording; exit 1 if it is not adequate");
  CLI::Option* const verify_rig = verify_verb->add_option("--rig", verifying.rig, kRigHelp);
  CLI::Option* const verify_data =
      verify_verb->add_option("data", verifying.data, std::string(kDataHelp) + "; without one the service is asked");
  verify_rig->needs(verify_data);
  verify_verb
      ->add_option("--dwell", verifying.dwell, "index of the dwell of a recording; default: the last that settled")
      ->needs(verify_data);
  add_service(verify_verb, service);

  HandonVerbs handing_on(app);

  RecordVerbs record(app, service);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  if (const auto code = record.run()) return *code;
  if (*status_verb) return status(service);
  if (*watch_verb) return watch(service, watching);
  if (*channels_verb) return channels(service);
  if (*dwells_verb) return dwells(service);
  if (*start_verb) return start_run(service, label, comment);
  if (*stop_verb) return stop_run(service, comment);
  if (*rearm_verb) return rearm(service, comment);
  if (*alarms_verb) return alarms(service);
  if (*acknowledge_verb) return acknowledge(service, alarm_names, comment);
  if (*check_verb) return check(service, rig);
  if (*verify_verb) {
    verifying.json = service.json;
    return verifying.data.empty() ? verify(service) : verify_recording(verifying);
  }
  if (*replay_verb) return replay(replaying);
  if (const auto code = handing_on.run()) return *code;
  return identify_recording(identifying);
}

}  // namespace

int main(int argc, char** argv) {
  int code = kUsage;
  try {
    code = run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "dwellctl: %s\n", error.what());
  }
  if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0) {
    std::fputs("dwellctl: standard output cannot be written\n", stderr);
    return kUsage;
  }
  return code;
}
