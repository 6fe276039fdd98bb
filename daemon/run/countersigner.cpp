#include "daemon/run/countersigner.hpp"

#include <pthread.h>
#include <pwd.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "daemon/clock.hpp"
#include "daemon/record/audit.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/key_file.hpp"
#include "daemon/record/ledger_book.hpp"
#include "daemon/record/ledger_check.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/record/signature.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json_value.hpp"

namespace dwell {
namespace {

// Most files that wait: the control socket has sixteen callers.
constexpr std::size_t kMostWaiting = 16;

tl::unexpected<std::string> fail(std::string why) { return tl::unexpected(std::move(why)); }

// The user as the system knows it: login name, and the name in full where it states one.
struct User {
  std::string login, full;
};

User user_of(std::uint32_t uid) {
  passwd entry{};
  passwd* found = nullptr;
  std::vector<char> room(4096);
  // An entry may be longer; one of a megabyte is none.
  while (getpwuid_r(uid, &entry, room.data(), room.size(), &found) == ERANGE && room.size() < 1'000'000)
    room.resize(4 * room.size());
  if (found == nullptr) return {};
  const std::string full = entry.pw_gecos == nullptr ? "" : entry.pw_gecos;
  return {entry.pw_name, full.substr(0, full.find(','))};
}

// The member's text, empty where it is missing or null; nullopt: it is no text.
std::optional<std::string> text_of(const Json& request, const char* name) {
  const auto it = request.find(name);
  if (it == request.end() || it->is_null()) return "";
  if (!it->is_string()) return std::nullopt;
  return it->get<std::string>();
}

// Again while the service is closing the file.
record::Result<record::RunHeader> header_of(const std::string& path) {
  for (int tries = 0;; ++tries) {
    const auto reader = record::RunReader::open(path);
    if (reader) return reader->header();
    if (reader.error().cause() != record::Cause::read_again || !record::wait_for_service(tries))
      return fail(reader.error());
  }
}

// Fails where the ledger does not have this file for its run. A signature under a copy would be an entry of the ledger,
// and missing in the run's own file.
record::Result<void> is_file_of_run(const std::string& path, const record::RunHeader& header,
                                    const record::LedgerBook& book) {
  if (header.run == 0)
    return fail(path + ": is a child file, which no ledger knows: sign it with a key of your own (--key)");
  const auto known = book.runs().find(header.run);
  if (known == book.runs().end()) return fail(path + ": the ledger knows no such run");
  const std::string run = "run " + std::to_string(header.run);
  if (known->second.id != header.id) return fail(path + ": the ledger knows another run as " + run);
  if (known->second.file != std::filesystem::path(path).filename())
    return fail(path + ": is a copy of " + run + ", whose file is " + known->second.file +
                " in the ledger: take that one");
  return {};
}

}  // namespace

std::optional<record::Result<SignRequest>> parse_sign_request(std::string_view line, std::uint32_t uid) {
  // The parser recurses into each bracket.
  if (std::count(line.begin(), line.end(), '[') + std::count(line.begin(), line.end(), '{') > 64) return std::nullopt;
  const Json request = Json::parse(line, nullptr, false);
  if (!request.is_object()) return std::nullopt;
  const auto verb = text_of(request, "verb");
  if (verb != "sign" && verb != "enter") return std::nullopt;
  SignRequest sign;
  sign.enter = verb == "enter";
  sign.uid = uid;
  for (const auto& [name, to] :
       std::initializer_list<std::pair<const char*, std::string*>>{{"file", &sign.file},
                                                                   {"name", &sign.statement.name},
                                                                   {"meaning", &sign.statement.meaning},
                                                                   {"reason", &sign.statement.reason}}) {
    auto text = text_of(request, name);
    if (!text) return fail(std::string(name) + ": expected a text");
    *to = std::move(*text);
  }
  if (sign.file.empty()) return fail("no file: expected the path of a run file");
  if (sign.statement.meaning.empty() && !sign.enter) return fail("no meaning: expected for instance \"reviewed\"");
  return sign;
}

std::string sign_answer(const record::Result<Signed>& result) {
  if (!result) return dump(Json{{"error", result.error()}});
  if (!result->signature) return dump(Json{{"run", result->run}, {"entered", result->entered}});
  return dump(Json{{"run", result->run}, {"signature", Json::parse(record::to_json(*result->signature))}});
}

record::Result<std::string> run_file_in(const std::string& directory, const std::string& file) {
  namespace fs = std::filesystem;
  const fs::path asked(file);
  std::error_code failed;
  const fs::path folder = fs::canonical(directory, failed);
  if (failed) return fail(directory + ": " + failed.message());
  const fs::path parent = asked.has_parent_path() ? fs::canonical(asked.parent_path(), failed) : folder;
  if (failed || parent != folder)
    return fail(file + " is not in the recording directory " + folder.string() +
                ": the service signs and enters only run files in its recording directory");
  const std::string path = (folder / asked.filename()).string();
  if (asked.extension() != ".dwell") return fail(path + " is no run file, expected NAME.dwell");
  struct stat is {};
  if (lstat(path.c_str(), &is) != 0) return fail(path + ": there is no such file");
  if (!S_ISREG(is.st_mode)) return fail(path + " is no regular file");
  return path;
}

Countersigner::Countersigner(std::string directory, Enter enter)
    : directory_(std::move(directory)), enter_(std::move(enter)), thread_([this] { run(); }) {}

Countersigner::~Countersigner() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  job_came_.notify_one();
  thread_.join();
  for (const Job& job : jobs_) job.done(fail("the service is stopping"));
}

void Countersigner::ask(SignRequest request, Done done) {
  {
    const std::lock_guard lock(mutex_);
    if (jobs_.size() < kMostWaiting) {
      jobs_.push_back({std::move(request), std::move(done)});
      done = nullptr;
    }
  }
  job_came_.notify_one();
  if (done) done(fail("too many files wait to be signed; try again"));
}

void Countersigner::run() {
  pthread_setname_np(pthread_self(), "sign");
  std::unique_lock lock(mutex_);
  while (true) {
    job_came_.wait(lock, [this] { return stopping_ || !jobs_.empty(); });
    if (stopping_) return;
    const Job job = std::move(jobs_.front());
    jobs_.pop_front();
    lock.unlock();
    job.done(answer_to(job.request));
    lock.lock();
  }
}

// An exception must not end the thread. Possible causes: no memory, or a user name that is not UTF-8.
record::Result<Signed> Countersigner::answer_to(const SignRequest& request) const {
  try {
    const auto path = run_file_in(directory_, request.file);
    if (!path) return fail(path.error() + (request.enter ? "" : "; a key of your own signs any run file"));
    return request.enter ? enter(*path) : sign(request, *path);
  } catch (const std::exception& error) {
    return fail(request.file + ": " + error.what());
  }
}

record::Result<Signed> Countersigner::sign(const SignRequest& request, const std::string& path) const {
  const User user = user_of(request.uid);
  record::PersonalSignature words = request.statement;
  words.person = record::Person{request.uid, user.login};
  if (words.name.empty()) words.name = user.full.empty() ? user.login : user.full;
  if (words.name.empty()) return fail("no name: the system does not know uid " + std::to_string(request.uid));
  words.utc = record::iso_utc(utc_now_ns());
  const auto header = header_of(path);
  if (!header) return fail(header.error());
  const auto book = record::read_book(record::ledger_in(directory_));
  if (!book) return fail(book.error());
  if (const auto known = is_file_of_run(path, *header, *book); !known) return fail(known.error());
  // The key is read each time: the recorder makes it, and it may change.
  const auto key = record::SigningKey::load(record::key_path(directory_));
  if (!key) return fail(key.error());
  auto signature = record::sign_by_service(path, std::move(words), *key);
  if (!signature) return fail(signature.error());
  if (const auto entered = enter_(header->run, *signature); !entered)
    return fail(path + " is signed, but the ledger does not know of it: " + entered.error() +
                "; once that is mended, enter it with dwellctl sign --enter");
  return Signed{header->run, std::move(*signature), 1};
}

// The audit verifies the signatures, and that the file is the run that the ledger knows by its number.
record::Result<Signed> Countersigner::enter(const std::string& path) const {
  record::AuditOptions options;
  options.ledger = record::ledger_in(directory_);
  options.stop = [this] {
    const std::lock_guard lock(mutex_);
    return stopping_;
  };
  auto ledger = record::check_ledger(options.ledger, options);
  if (!ledger) return fail(ledger.error());
  options.checked = std::make_shared<const record::CheckedLedger>(std::move(*ledger));
  const auto audit = record::audit_run(path, options);
  if (!audit) return fail(audit.error());
  if (audit->state != record::AuditState::intact)
    return fail(path + " is " + to_string(audit->state) + (audit->where.empty() ? "" : ": " + audit->where));
  auto reader = record::RunReader::open(path);
  if (!reader) return fail(reader.error());
  if (const auto known = is_file_of_run(path, reader->header(), options.checked->book); !known)
    return fail(known.error());
  Signed done{reader->header().run, std::nullopt, 0};
  const record::LedgerRun* const known = options.checked->find(done.run);
  const auto signatures = reader->signatures();
  if (!signatures) return fail(signatures.error());
  for (const record::PersonalSignature& signature : *signatures) {
    const std::string body = to_json(signature);
    if (std::any_of(known->signatures.begin(), known->signatures.end(),
                    [&body](const record::PersonalSignature& one) { return to_json(one) == body; }))
      continue;
    if (const auto entered = enter_(done.run, signature); !entered)
      return fail("the ledger could not be told of the signature of " + signature.name + ": " + entered.error());
    ++done.entered;
  }
  return done;
}

}  // namespace dwell
