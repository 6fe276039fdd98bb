// dwellctl: from the command line to the verbs of commands.hpp.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/handon_verbs.hpp"

namespace {

using namespace dwell::ctl;

constexpr const char* kExitCodes =
    "Exit codes: 0 done, 1 the answer is no, 2 wrong usage or unusable input, 3 the service cannot be reached.";

void add_json(CLI::App* verb, bool& json) { verb->add_flag("--json", json, "print JSON"); }

void add_service(CLI::App* verb, Service& service) {
  verb->add_option("--url", service.url, "address of the service's HTTP interface")
      ->envname("DWELL_URL")
      ->capture_default_str();
  add_json(verb, service.json);
}

void add_control(CLI::App* verb, Service& service) {
  verb->add_option("--control", service.control, "the service's control socket")
      ->envname("DWELL_CONTROL")
      ->capture_default_str();
}

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

  CLI::App* rearm_verb = app.add_subcommand("rearm", "end the dwell here and settle anew");
  add_control(rearm_verb, service);
  add_json(rearm_verb, service.json);

  CLI::App* check_verb = app.add_subcommand("check", "each device probed once; exit 1 if a channel does not answer");
  check_verb->add_option("--rig", rig, "probe the devices of this rig file, without the service");
  add_control(check_verb, service);
  add_json(check_verb, service.json);

  CLI::App* identify_verb = app.add_subcommand("identify", "coefficients from a recording; exit 1 if no dwell settled");
  identify_verb->add_option("--rig", identifying.rig, "the rig file; its devices are not needed")->required();
  identify_verb->add_option("data", identifying.data, "the recording, CSV: t,NAME,… or t,channel,value")->required();
  identify_verb
      ->add_option("--method", identifying.method,
                   "harmonic: steady dwells; motion: maximum likelihood on any motion; both (default)")
      ->check(CLI::IsMember({"harmonic", "motion", "both"}));
  add_json(identify_verb, identifying.json);

  VerifyOptions verifying;
  CLI::App* verify_verb = app.add_subcommand(
      "verify", "the model against transients it never saw, live or of a recording; exit 1 if it is not adequate");
  CLI::Option* const verify_rig =
      verify_verb->add_option("--rig", verifying.rig, "the recording's rig file; its devices are not needed");
  CLI::Option* const verify_data = verify_verb->add_option(
      "data", verifying.data, "a recording, CSV: t,NAME,… or t,channel,value; without one the service is asked");
  verify_rig->needs(verify_data);
  verify_data->needs(verify_rig);
  verify_verb
      ->add_option("--dwell", verifying.dwell, "index of the dwell of a recording; default: the last that settled")
      ->needs(verify_data);
  add_service(verify_verb, service);

  HandonVerbs handing_on(app);

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUsage;
  }
  if (*status_verb) return status(service);
  if (*watch_verb) return watch(service, watching);
  if (*channels_verb) return channels(service);
  if (*dwells_verb) return dwells(service);
  if (*rearm_verb) return rearm(service);
  if (*check_verb) return check(service, rig);
  if (*verify_verb) {
    verifying.json = service.json;
    return verifying.data.empty() ? verify(service) : verify_recording(verifying);
  }
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
