// sign: a person's signature under a run that has ended, vouched for by the service or with a key of their own. Either
// becomes an entry of the ledger, where the service is at hand.
#include <pwd.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <tl/expected.hpp>

#include "core/base/printable.hpp"
#include "daemon/clock.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/control_client.hpp"
#include "daemon/ctl/recorded_run.hpp"
#include "daemon/ctl/run_summary.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/record/signature.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json_value.hpp"

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

std::string signed_text(const record::PersonalSignature& signature, const std::string& file) {
  return printable(file + ": signed: " + signature_text(signature)) + "\n";
}

int print(const Json& answer, const std::string& text, bool json) {
  const std::string out = json ? dump(answer, 2) + "\n" : text;
  std::fwrite(out.data(), 1, out.size(), stdout);
  return kDone;
}

std::string absolute_path(const std::string& file) {
  std::error_code failed;
  const auto path = std::filesystem::absolute(file, failed);
  return failed ? file : path.string();
}

// Why the service gave no answer to use, and the exit code for that.
struct Refusal {
  int code;
  std::string why;
};

// The service's answer, a JSON object.
tl::expected<Json, Refusal> ask_service(const Service& service, const Json& request) {
  ControlLimits limits;
  limits.time = kAnswerTime;
  const auto line = control_exchange(service.control, dump(request), limits);
  if (!line) return tl::unexpected(Refusal{kUnreachable, line.error()});
  Json answer = Json::parse(*line, nullptr, false);
  if (!answer.is_object())
    return tl::unexpected(Refusal{kUnreachable, service.control + ": what answers is not the service"});
  const auto error = answer.find("error");
  if (error != answer.end() && error->is_string())
    return tl::unexpected(Refusal{kNo, service.control + ": " + error->get<std::string>()});
  return answer;
}

tl::expected<Json, Refusal> enter(const Service& service, const std::string& file) {
  return ask_service(service, Json{{"verb", "enter"}, {"file", absolute_path(file)}});
}

// The signature stands in the file before the service is asked, which may take up to kAnswerTime. Whatever the service
// answers is no failure, for the file may lie anywhere: the output says whether the ledger knows the signature.
int sign_with_own_key(const Service& service, const SignOptions& options) {
  const auto key = record::SigningKey::load(options.key);
  if (!key) {
    std::error_code none;
    const bool is_there = std::filesystem::exists(options.key, none);
    return refuse(kUsage, "--key: " + key.error() + (is_there ? "" : "; dwellctl keygen makes one"));
  }
  record::PersonalSignature words;
  words.name = options.name.empty() ? own_name() : options.name;
  if (words.name.empty()) return refuse(kUsage, "the system does not know who you are: expected --name");
  words.meaning = options.meaning;
  words.reason = options.reason;
  words.utc = record::iso_utc(utc_now_ns());
  const auto signature = record::sign_by_own_key(options.file, std::move(words), *key);
  if (!signature) return refuse(kUsage, signature.error());
  const auto reader = record::RunReader::open(options.file);
  const bool child = reader && reader->header().is_child();
  const auto entered =
      child ? tl::unexpected(Refusal{kNo, "no ledger knows child files"}) : enter(service, options.file);
  const std::string why = entered ? "" : entered.error().why;
  return print(
      Json{{"signature", Json::parse(to_json(*signature))},
           {"in_ledger", entered.has_value()},
           {"not_in_ledger", why.empty() ? Json(nullptr) : Json(why)}},
      signed_text(*signature, options.file) +
          (entered ? "  the ledger knows it\n"
                   : "  not in the ledger: " + printable(why) +
                         (child ? "\n" : ". Where the service has this file, dwellctl sign --enter enters it\n")),
      service.json);
}

int enter_signatures(const Service& service, const SignOptions& options) {
  const auto answer = enter(service, options.file);
  if (!answer) return refuse(answer.error().code, answer.error().why);
  const auto count = answer->find("entered");
  if (count == answer->end() || !count->is_number_unsigned())
    return refuse(kUnreachable, service.control + ": what answers is not the service: no number of entries");
  const auto n = count->get<std::uint64_t>();
  return print(
      *answer,
      printable(options.file) + ": " +
          (n == 0 ? "the ledger knows all its signatures\n"
                  : "entered into the ledger: " + std::to_string(n) + (n == 1 ? " signature\n" : " signatures\n")),
      service.json);
}

int sign_through_service(const Service& service, const SignOptions& options) {
  const auto answer = ask_service(service, Json{{"verb", "sign"},
                                                {"file", absolute_path(options.file)},
                                                {"name", options.name},
                                                {"meaning", options.meaning},
                                                {"reason", options.reason}});
  std::error_code none;
  if (!answer && answer.error().code == kNo && !std::filesystem::exists(options.file, none) && !none)
    return refuse(kUsage, options.file + ": No such file or directory");
  if (!answer)
    return refuse(answer.error().code,
                  answer.error().why + (answer.error().code == kUnreachable
                                            ? "; where no service runs, --key FILE signs with a key of your own"
                                            : ""));
  const auto made = answer->find("signature");
  const auto signature = made == answer->end() ? tl::unexpected(std::string("no signature"))
                                               : record::parse_personal_signature(made->dump());
  if (!signature)
    return refuse(kUnreachable, service.control + ": what answers is not the service: " + signature.error());
  return print(*answer, signed_text(*signature, options.file), service.json);
}

}  // namespace

int sign(const Service& service, const SignOptions& options) {
  if (options.enter) return enter_signatures(service, options);
  if (options.meaning.empty()) return refuse(kUsage, "expected --meaning, for instance \"reviewed\", or --enter");
  if (options.key.empty()) return sign_through_service(service, options);
  return sign_with_own_key(service, options);
}

}  // namespace dwell::ctl
