// keygen: a key of a person's own, to sign runs with.
#include <cstdio>
#include <string>

#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/personal_key.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell::ctl {
namespace {

int refuse(const std::string& why) {
  tell_error(why);
  return kUsage;
}

}  // namespace

int make_key(const KeyOptions& options) {
  const record::Result<std::string> usual = options.file.empty() ? personal_key_path() : options.file;
  if (!usual) return refuse(usual.error());
  const std::string& file = *usual;
  const auto key = record::SigningKey::make(options.name.empty() ? personal_key_name() : options.name);
  if (!key) return refuse(key.error());
  if (const auto saved = save_personal_key(*key, file); !saved) return refuse(saved.error());
  const std::string pub = file + ".pub";
  const record::PublicKey& own = key->public_key();
  if (options.json) {
    const Json answer{{"private", file}, {"public", pub}, {"vkey", own.vkey()}, {"fingerprint", own.fingerprint()}};
    std::printf("%s\n", dump(answer, 2).c_str());
  } else {
    std::printf("private key  %s\npublic key   %s\n%s\nfingerprint  %s\n", file.c_str(), pub.c_str(),
                own.vkey().c_str(), own.fingerprint().c_str());
  }
  return kDone;
}

}  // namespace dwell::ctl
