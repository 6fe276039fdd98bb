// keygen: a key of a person's own, to sign runs with.
#include <pwd.h>
#include <unistd.h>

#include <climits>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {
namespace {

namespace fs = std::filesystem;

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

// Where programs keep what is the user's; empty: nowhere.
std::string usual_file() {
  if (const std::string folder = variable("XDG_CONFIG_HOME"); !folder.empty()) return folder + "/dwell/key";
  const std::string home = variable("HOME");
  return home.empty() ? "" : home + "/.config/dwell/key";
}

std::string usual_name() {
  const passwd* user = getpwuid(getuid());
  char host[HOST_NAME_MAX + 1] = {};
  (void)gethostname(host, sizeof host - 1);
  return (user == nullptr ? std::to_string(getuid()) : std::string(user->pw_name)) + "@" + host;
}

int refuse(const std::string& why) {
  tell_error(why);
  return kUsage;
}

}  // namespace

int make_key(const KeyOptions& options) {
  const fs::path file = options.file.empty() ? usual_file() : options.file;
  if (file.empty()) return refuse("there is no home directory: expected --key FILE");
  const auto key = record::SigningKey::make(options.name.empty() ? usual_name() : options.name);
  if (!key) return refuse(key.error());
  std::error_code failed;
  if (file.has_parent_path()) fs::create_directories(file.parent_path(), failed);
  if (const auto saved = key->save(file.string()); !saved) return refuse(saved.error());
  const std::string pub = file.string() + ".pub";
  const record::PublicKey& own = key->public_key();
  std::ofstream text(pub);
  text << own.vkey() << "\n";
  text.close();
  if (!text) return refuse(pub + " cannot be written; the public key is " + own.vkey());
  if (options.json) {
    const Json answer{
        {"private", file.string()}, {"public", pub}, {"vkey", own.vkey()}, {"fingerprint", own.fingerprint()}};
    std::printf("%s\n", dump(answer, 2).c_str());
  } else {
    std::printf("private key  %s\npublic key   %s\n%s\nfingerprint  %s\n", file.c_str(), pub.c_str(),
                own.vkey().c_str(), own.fingerprint().c_str());
  }
  return kDone;
}

}  // namespace dwell::ctl
