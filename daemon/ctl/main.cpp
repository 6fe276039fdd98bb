// dwellctl: from the command line to the verbs of commands.hpp.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>
#include <vector>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/handon_verbs.hpp"
#include "daemon/ctl/options.hpp"
#include "daemon/ctl/record_verbs.hpp"
#include "daemon/ctl/verbs.hpp"

namespace {

using namespace dwell::ctl;

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 the answer is no, 2 wrong usage or unusable input, 3 the service cannot be reached.";

constexpr const char* kRigHelp =
    "the rig file; its devices are not needed. For a run file: another rig file than its own";
constexpr const char* kDataHelp = "a run file, or a recording as CSV: t,NAME,… or t,channel,value";

// What the service says.
class ServiceVerbs {
 public:
  ServiceVerbs(Verbs& verbs, Service& service) {
    add_service(verbs.add("status", "the current dwell; exit 1 if it is not measuring or not to be relied on",
                          [&] { return status(service); }),
                service);
    CLI::App* const watch = verbs.add("watch", "the current dwell, refreshed until q or Ctrl-C",
                                      [&, this] { return dwell::ctl::watch(service, watching_); });
    add_service(watch, service);
    add_control(watch, service);
    watch->add_option("--interval", watching_.interval_s, "s between refreshes")->check(CLI::Range(0.01, 3600.0));
    watch->add_option("--until", watching_.until_s, "end once a settled dwell has so many seconds of data")
        ->check(CLI::Range(0.0, 1e9));
    watch->add_option("--limit", watching_.limit_s, "give up, with exit 1, after so many seconds")
        ->check(CLI::Range(0.0, 1e9));
    watch->add_option("--truth", watching_.truth,
                      "JSON file with the coefficients of a simulated rig, shown beside the measured ones; with "
                      "--until, exit 1 if one is off by more than 4 standard uncertainties");
    add_service(verbs.add("channels", "every channel: value, status, rate, counts", [&] { return channels(service); }),
                service);
    add_service(verbs.add("dwells", "the dwells that have been completed", [&] { return dwells(service); }), service);
  }

 private:
  WatchOptions watching_;
};

// What an operator asks the service to do, and what needs an operator.
class OperatorVerbs {
 public:
  OperatorVerbs(Verbs& verbs, Service& service) {
    const auto asks = [&service, this](CLI::App* verb) {
      add_text(verb, "--comment", comment_, dwell::record::kCommentBytes, "why, for the record");
      add_control(verb, service);
      add_json(verb, service.json);
    };
    CLI::App* const start = verbs.add(
        "start", "begin a recorded run now; exit 1 if an operator's run goes on already, or if nothing is recorded",
        [&service, this] { return start_run(service, label_, comment_); });
    const auto needs_label = [this](CLI::App* verb, const char* name) {
      add_text(verb, name, label_, dwell::record::kLabelBytes, "what the run is")
          ->required()
          ->check([](const std::string& given) { return given.empty() ? "expected text" : ""; }, "");
    };
    needs_label(start, "--label");
    asks(start);
    CLI::App* const label = verbs.add("label", "name the recorded run that goes on; exit 1 if none does",
                                      [&service, this] { return label_run(service, label_, comment_); });
    needs_label(label, "label");
    asks(label);
    asks(verbs.add("stop", "end the recorded run now; exit 1 if none goes on",
                   [&service, this] { return stop_run(service, comment_); }));
    asks(verbs.add("rearm", "end the dwell here and settle anew",
                   [&service, this] { return rearm(service, comment_); }));
    add_service(verbs.add("alarms", "what is wrong and lasts; exit 1 if there is anything",
                          [&service] { return alarms(service); }),
                service);
    CLI::App* const acknowledge =
        verbs.add("acknowledge", "say that you know of an alarm; exit 1 if there is none of that name",
                  [&service, this] { return dwell::ctl::acknowledge(service, alarms_, comment_); });
    acknowledge->add_option("alarm", alarms_, "names, as in the list of alarms")->required();
    asks(acknowledge);
    CLI::App* const check =
        verbs.add("check", "each device probed once; exit 1 if a channel does not answer or is gated",
                  [&service, this] { return dwell::ctl::check(service, rig_); });
    check->add_option("--rig", rig_, "probe the devices of this rig file, without the service");
    add_control(check, service);
    add_json(check, service.json);
  }

 private:
  std::string label_, comment_, rig_;
  std::vector<std::string> alarms_;
};

// What is computed here, from recordings.
class ComputingVerbs {
 public:
  ComputingVerbs(Verbs& verbs, Service& service) {
    add_identify(verbs);
    add_replay(verbs);
    add_verify(verbs, service);
  }

 private:
  void add_identify(Verbs& verbs) {
    CLI::App* const verb = verbs.add("identify", "coefficients from a recording; exit 1 if no dwell settled",
                                     [this] { return identify_recording(identifying_); });
    verb->add_option("--rig", identifying_.rig, kRigHelp);
    verb->add_option("data", identifying_.data, kDataHelp)->required();
    verb->add_option("--method", identifying_.method,
                     "harmonic: steady dwells; motion: maximum likelihood on any motion; both (default)")
        ->check(CLI::IsMember({"harmonic", "motion", "both"}));
    add_json(verb, identifying_.json);
  }
  void add_replay(Verbs& verbs) {
    CLI::App* const verb =
        verbs.add("replay", "a run computed again from its stream; exit 1 if that differs from what was stored",
                  [this] { return replay(replaying_); });
    verb->add_option("file", replaying_.file, "the run file")->required();
    CLI::Option* const rig =
        verb->add_option("--rig", replaying_.rig,
                         "compute with this rig file instead, and compare nothing; it must have the run's channels");
    CLI::Option* const child =
        verb->add_option("-o,--output", replaying_.output, "the child file to write")->needs(rig);
    CLI::Option* const against =
        verb->add_option("--against", replaying_.against,
                         "a child file of this run: compute with its rig file, and compare with its results")
            ->excludes(rig);
    verb->add_flag("--models", replaying_.models,
                   "compare estimates by any motion and verifications too; each takes seconds, some minutes")
        ->excludes(rig)
        ->excludes(against);
    add_text(verb, "--comment", replaying_.comment, dwell::record::kCommentBytes, "why, into the child file")
        ->needs(child);
    verb->add_option("--key", replaying_.key, "file of the private key that signs the child file; default: your own")
        ->needs(child);
    add_json(verb, replaying_.json);
  }
  void add_verify(Verbs& verbs, Service& service) {
    CLI::App* const verb = verbs.add(
        "verify", "the model against transients it never saw, live or of a recording; exit 1 if it is not adequate",
        [&service, this] {
          verifying_.json = service.json;
          return verifying_.data.empty() ? verify(service) : verify_recording(verifying_);
        });
    CLI::Option* const rig = verb->add_option("--rig", verifying_.rig, kRigHelp);
    CLI::Option* const data =
        verb->add_option("data", verifying_.data, std::string(kDataHelp) + "; without one the service is asked");
    rig->needs(data);
    verb->add_option("--dwell", verifying_.dwell, "index of the dwell of a recording; default: the last that settled")
        ->needs(data);
    add_service(verb, service);
  }

  IdentifyOptions identifying_;
  ReplayOptions replaying_;
  VerifyOptions verifying_;
};

int run(int argc, char** argv) {
  CLI::App app("Asks the dwell service, and identifies stiffness and damping from recordings.", "dwellctl");
  app.set_version_flag("--version", DWELL_VERSION);
  app.footer(kExitCodes);
  Service service;
  service.url = "http://127.0.0.1:8380";
  service.control = "/run/dwell/control";

  Verbs verbs(app);
  ServiceVerbs asking(verbs, service);
  OperatorVerbs operating(verbs, service);
  ComputingVerbs computing(verbs, service);
  HandonVerbs handing_on(verbs);
  RecordVerbs record(verbs, service);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  return verbs.run();
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
