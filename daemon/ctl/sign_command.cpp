// sign: a person's signature under a run that has ended, vouched for by the service or with a key of their own.
#include <pwd.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>

#include "daemon/clock.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/control_client.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/ctl/run_summary.hpp"
#include "daemon/record/signature.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json_value.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::ctl {
namespace {

// Time allowed for the service's answer. It first reads this run file, and those that others asked to sign before. 30
// min are enough for 100 GB at 60 MB/s.
constexpr std::chrono::minutes kAnswerTime{30};

int refuse(int code, const std::string& why) {
  tell_error(why);
  return code;
}

// The name in full where the system states one, or the login name.
std::string own_name() {
  const passwd* user = getpwuid(getuid());
  if (user == nullptr) return "";
  const std::string full = user->pw_gecos == nullptr ? "" : user->pw_gecos;
  const std::string name = full.substr(0, full.find(','));
  return name.empty() ? user->pw_name : name;
}

int print(const Json& answer, const record::PersonalSignature& signature, const std::string& file, bool json) {
  const std::string text =
      json ? dump(answer, 2) + "\n" : printable(file + ": signed: " + signature_text(signature)) + "\n";
  std::fwrite(text.data(), 1, text.size(), stdout);
  return kDone;
}

int sign_with_own_key(const SignOptions& options, bool json) {
  const auto key = record::SigningKey::load(options.key);
  if (!key) return refuse(kUsage, "--key: " + key.error() + "; dwellctl keygen makes one");
  record::PersonalSignature words;
  words.name = options.name.empty() ? own_name() : options.name;
  if (words.name.empty()) return refuse(kUsage, "the system does not know who you are: expected --name");
  words.meaning = options.meaning;
  words.reason = options.reason;
  words.utc = record::iso_utc(utc_now_ns());
  const auto signature = record::sign_by_own_key(options.file, std::move(words), *key);
  if (!signature) return refuse(kUsage, signature.error());
  return print(Json{{"signature", Json::parse(to_json(*signature))}}, *signature, options.file, json);
}

int sign_through_service(const Service& service, const SignOptions& options) {
  std::error_code failed;
  const auto file = std::filesystem::absolute(options.file, failed);
  const Json request{{"verb", "sign"},
                     {"file", failed ? options.file : file.string()},
                     {"name", options.name},
                     {"meaning", options.meaning},
                     {"reason", options.reason}};
  ControlLimits limits;
  limits.time = kAnswerTime;
  const auto line = control_exchange(service.control, dump(request), limits);
  if (!line)
    return refuse(kUnreachable, line.error() + "; where no service runs, --key FILE signs with a key of your own");
  const Json answer = Json::parse(*line, nullptr, false);
  const auto error = answer.is_object() ? answer.find("error") : answer.end();
  if (error != answer.end() && error->is_string())
    return refuse(kNo, service.control + ": " + error->get<std::string>());
  const auto made = answer.is_object() ? answer.find("signature") : answer.end();
  const auto signature = made == answer.end() ? tl::unexpected(std::string("no signature"))
                                              : record::parse_personal_signature(made->dump());
  if (!signature)
    return refuse(kUnreachable, service.control + ": what answers is not the service: " + signature.error());
  return print(answer, *signature, options.file, service.json);
}

}  // namespace

int sign(const Service& service, const SignOptions& options) {
  if (options.meaning.empty()) return refuse(kUsage, "--meaning is empty: expected for instance \"reviewed\"");
  if (options.key.empty()) return sign_through_service(service, options);
  return sign_with_own_key(options, service.json);
}

}  // namespace dwell::ctl
