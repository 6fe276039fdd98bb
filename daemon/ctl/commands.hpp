// The verbs of dwellctl. Each prints to standard output, says what is wrong on standard error, and returns the exit
// code; main.cpp turns the command line into their options.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

namespace dwell::ctl {

// The exit codes of the interface.
enum Exit : int {
  kDone = 0,
  kNo = 1,           // the answer is no: not settled, not identifiable, a device does not answer
  kUsage = 2,        // wrong usage or unusable input
  kUnreachable = 3,  // the service cannot be reached, or what answers is not the service
};

struct Service {
  std::string url;         // of the HTTP interface
  std::string token_file;  // of the token that the service asks for from another computer; empty: none
  std::string control;     // path of the control socket
  bool json = false;
};

struct WatchOptions {
  double interval_s = 0.0;  // between refreshes; 0: 0.1 s on a terminal, 1 s elsewhere
  double until_s = 0.0;     // > 0: end once a settled dwell has so many seconds of data
  double limit_s = 0.0;     // > 0: give up after so long
  std::string truth;        // file: the coefficients that the simulated rig really has
};

// Of a recording: data is a run file, or CSV, which needs a rig.
struct IdentifyOptions {
  std::string rig = {};
  std::string data = {};
  std::string method = "both";  // "harmonic", "motion" or "both"
  bool json = false;
};

struct ReplayOptions {
  std::string file = {};
  std::string rig = {};      // another rig file; empty: the run's own
  std::string output = {};   // with a rig: the child file to write; empty: none
  std::string against = {};  // a child file to compare with; empty: the run's own results
  std::string comment = {};  // into the child file
  std::string key = {};      // file of the private key that signs it; empty: the person's own
  bool models = false;       // compare the run's estimates by any motion and its verifications too
  bool json = false;
};

struct VerifyOptions {
  std::string rig = {};
  std::string data = {};
  std::optional<int> dwell = {};  // its index; none: the last that settled
  bool json = false;
};

struct ExportOptions {
  std::string rig = {};
  std::string data = {};
  std::string folder = {};
  std::optional<int> dwell = {};
  bool overwrite = false;  // existing files in the folder
};

struct AuditRequest {
  std::vector<std::string> files;
  std::string ledger;                // file; empty: none
  bool ledger_beside = false;        // the ledger is the one beside the run files
  std::vector<std::string> keys;     // pinned, see pinned_keys()
  std::vector<std::string> persons;  // pinned too: keys of persons
  std::vector<std::string> anchors;  // files
  bool every_signature = false;      // AuditOptions
  bool closed = false;               // a file without an end counts as a failure
  bool json = false;
};

struct SignOptions {
  std::string file;
  bool enter = false;  // sign nothing; have the service enter the signatures that its ledger does not know
  std::string meaning;
  std::string name;    // empty: as the system calls the user
  std::string reason;  // may be empty
  std::string key;     // file of a private key of the person's own; empty: the service vouches
};

struct KeyOptions {
  std::string file;  // empty: key in $XDG_CONFIG_HOME/dwell or ~/.config/dwell
  std::string name;  // empty: USER@HOST
  bool json = false;
};

[[nodiscard]] int status(const Service& service);
[[nodiscard]] int watch(const Service& service, const WatchOptions& options);
[[nodiscard]] int channels(const Service& service);
[[nodiscard]] int dwells(const Service& service);
// Operators' requests to the service. rearm: end the dwell and settle anew. start_run, stop_run: begin and end a
// recorded run. label_run: name the one that goes on. comment: empty: none.
[[nodiscard]] int rearm(const Service& service, const std::string& comment);
[[nodiscard]] int start_run(const Service& service, const std::string& label, const std::string& comment);
[[nodiscard]] int label_run(const Service& service, const std::string& label, const std::string& comment);
[[nodiscard]] int stop_run(const Service& service, const std::string& comment);
// The list of alarms; kNo if there is any.
[[nodiscard]] int alarms(const Service& service);
// names: of alarms, one after the other until one fails.
[[nodiscard]] int acknowledge(const Service& service, const std::vector<std::string>& names,
                              const std::string& comment);
// rig: a rig file, whose devices are probed directly; empty: the running service is asked.
[[nodiscard]] int check(const Service& service, const std::string& rig);
// The newest verification of the running service.
[[nodiscard]] int verify(const Service& service);
[[nodiscard]] int identify_recording(const IdentifyOptions& options);
[[nodiscard]] int replay(const ReplayOptions& options);
[[nodiscard]] int verify_recording(const VerifyOptions& options);
[[nodiscard]] int export_model(const ExportOptions& options);

// Run files. directory: empty: the runs of the service.
[[nodiscard]] int audit_files(const AuditRequest& request);
[[nodiscard]] int runs(const Service& service, const std::string& directory);
[[nodiscard]] int show_run(const std::string& file, bool json);
[[nodiscard]] int sign(const Service& service, const SignOptions& options);
[[nodiscard]] int make_key(const KeyOptions& options);

// What `rearm` and the key of watch do: the service's answer as JSON text. The error: the exit code, and why.
struct Refusal {
  int code = kUnreachable;
  std::string why;
};
[[nodiscard]] tl::expected<std::string, Refusal> ask_to_rearm(const std::string& control_path,
                                                              std::chrono::milliseconds time);

}  // namespace dwell::ctl
