// dwelld: the service's command line, and what a process must set up before its first thread.
#include <signal.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "config/rig_file.hpp"
#include "core/base/printable.hpp"
#include "daemon/acquire/plugin.hpp"
#include "daemon/gpio/kernel_lines.hpp"
#include "daemon/gpio/panel.hpp"
#include "daemon/log/log.hpp"
#include "daemon/record/key_file.hpp"
#include "daemon/run/recording.hpp"
#include "daemon/serve/page_files.hpp"
#include "daemon/serve/rights.hpp"
#include "daemon/service.hpp"
#include "daemon/version.hpp"

namespace {

using dwell::config::RigFile;

constexpr int kDone = 0;
constexpr int kFailed = 1;
constexpr int kUnusable = 2;

// The first of the folders systemd names in a variable such as RUNTIME_DIRECTORY; empty: none.
std::string folder_of(const char* variable) {
  const char* const value = std::getenv(variable);
  const std::string folders = value == nullptr ? "" : value;
  return folders.substr(0, folders.find(':'));
}

std::string in_folder(const char* variable, const char* name) {
  const std::string folder = folder_of(variable);
  return folder.empty() ? folder : folder + "/" + name;
}

// libmodbus waits with select(), which a descriptor of 1024 or more would make write beyond its set.
bool limit_descriptors() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return false;
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_cur, 1024);
  return setrlimit(RLIMIT_NOFILE, &limit) == 0;
}

// Every thread inherits this: signals arrive on the event loop alone, a client that goes away is an error code.
void prepare_signals() {
  signal(SIGPIPE, SIG_IGN);
  const sigset_t signals = dwell::service_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
}

void print_summary(const RigFile& file) {
  std::printf("%s: rig \"%s\", %d masses, %d elements, %zu channels, %zu devices\n", file.path.c_str(),
              dwell::printable(file.rig.name).c_str(), file.rig.mass_count(), file.rig.element_count(),
              file.rig.channels.size(), file.devices.size());
  const auto tell = [&](const char* front, const std::string& note) {
    if (!note.empty()) std::printf("%s: %s%s\n", file.path.c_str(), front, dwell::printable(note).c_str());
  };
  for (const dwell::config::DeviceSettings& device : file.devices) {
    tell(device.asked_rate_hz ? "" : "warning: ", dwell::config::rate_note(file, device));
    tell("warning: ", dwell::config::line_note(device));
  }
}

// What only the service needs, beside a rig file without mistakes.
int check(const RigFile& file) {
  dwell::config::Mistakes mistakes;
  const auto add = [&mistakes](const auto& checked) {
    if (!checked) mistakes.insert(mistakes.end(), checked.error().begin(), checked.error().end());
  };
  add(dwell::read_access(file.server));
  if (file.modbus_server) add(dwell::check_modbus_access(*file.modbus_server));
  if (!mistakes.empty()) {
    std::fputs(dwell::config::to_string(file.path, mistakes).c_str(), stderr);
    return kUnusable;
  }
  print_summary(file);
  if (!file.server.token_file.empty()) {
    const auto note = dwell::unreadable_token_note(file.server.token_file, DWELL_SERVICE_USER);
    const dwell::config::Position at = file.server.token_file_at;
    if (!note.empty())
      std::fputs(dwell::config::to_string(file.path, {{at.line, at.column, "warning: token_file: " + note}}).c_str(),
                 stderr);
  }
  return kDone;
}

int darken_lamps(const RigFile& file) {
  dwell::gpio::KernelLines lines;
  const auto faults = dwell::gpio::lamps_off(file.gpio, lines);
  for (const std::string& fault : faults) std::fprintf(stderr, "dwelld: %s\n", fault.c_str());
  return faults.empty() ? kDone : kFailed;
}

int make_new_key(const RigFile& file) {
  const auto key = dwell::record::change_key(dwell::recording_directory(file), dwell::key_name(file));
  if (!key) {
    std::fprintf(stderr, "dwelld: %s\n", key.error().c_str());
    return kFailed;
  }
  std::printf("%s\nfingerprint %s\n", key->vkey().c_str(), key->fingerprint().c_str());
  return kDone;
}

int serve(RigFile file, const dwell::config::SchemaSource& drivers, const std::string& log_file,
          const std::string& control_path) {
  dwell::LogOptions log_options;
  log_options.file = log_file;
  auto log = dwell::Log::make(log_options);
  if (!log) {
    std::fprintf(stderr, "dwelld: %s\n", log.error().c_str());
    return kFailed;
  }
  dwell::ServiceOptions options;
  options.control_path = control_path;
  options.page_folder = dwell::own_page_folder();
  auto service = dwell::Service::make(std::move(file), drivers, options, **log);
  if (!service) {
    (*log)->error(service.error().message);
    return service.error().exit_code;
  }
  (*service)->run();
  return kDone;
}

}  // namespace

int main(int argc, char** argv) {
  std::string config_path;
  std::string check_path;
  std::string log_file = in_folder("LOGS_DIRECTORY", "dwelld.log");
  std::string control_path = in_folder("RUNTIME_DIRECTORY", "control");
  CLI::App app{"Measures the stiffness and damping of a harmonically shaken rig, live."};
  app.set_version_flag("--version", std::string("dwelld ") + dwell::kVersion);
  auto* const config_option = app.add_option("--config", config_path, "the rig file to serve");
  app.add_option("--check-config", check_path, "check a rig file, print every mistake, and exit")
      ->excludes(config_option);
  bool lamps_off = false;
  app.add_flag("--lamps-off", lamps_off, "darken the lamps of the rig file's [gpio] and exit: for after the service")
      ->needs(config_option);
  bool new_key = false;
  app.add_flag("--new-key", new_key, "change the key that signs recordings; print the new one and exit")
      ->needs(config_option);
  app.add_option("--log", log_file, "also log to this file, rotated (default: $LOGS_DIRECTORY/dwelld.log)");
  app.add_option("--control", control_path, "the control socket (default: $RUNTIME_DIRECTORY/control)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? kDone : kUnusable;
  }
  const std::string& path = check_path.empty() ? config_path : check_path;
  if (path.empty()) {
    std::fprintf(stderr, "dwelld: --config FILE or --check-config FILE is needed; --help says more\n");
    return kUnusable;
  }
  prepare_signals();
  const dwell::config::SchemaSource drivers = [](std::string_view name) {
    return dwell::acquire::load_plugin(std::string(name));
  };
  // Lamps and keys need no driver.
  auto file = dwell::config::load(path, lamps_off || new_key ? dwell::config::SchemaSource() : drivers);
  if (!file) {
    std::fputs(dwell::config::to_string(path, file.error()).c_str(), stderr);
    return kUnusable;
  }
  if (lamps_off) return darken_lamps(*file);
  if (new_key) return make_new_key(*file);
  if (!check_path.empty()) return check(*file);
  if (!limit_descriptors()) {
    std::fprintf(stderr, "dwelld: the number of open files cannot be limited\n");
    return kFailed;
  }
  try {
    return serve(std::move(*file), drivers, log_file, control_path);
  } catch (const std::exception& failure) {
    std::fprintf(stderr, "dwelld: %s\n", failure.what());
    return kFailed;
  }
}
