#include "daemon/record/run_audits.hpp"

#include <algorithm>
#include <exception>
#include <mutex>
#include <utility>

#include "daemon/clock.hpp"
#include "daemon/record/file_identity.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/ledger_check.hpp"
#include "daemon/record/low_priority.hpp"
#include "daemon/record/utc_text.hpp"

namespace dwell::record {
namespace {

// The ledger of the directory, verified again only when its file has changed. Bound to one thread.
class KnownLedger {
 public:
  // Fills in options.ledger, keys and checked. key: the service's. Fails if the ledger cannot be read.
  Result<void> give(AuditOptions& options, const std::string& path, const PublicKey& key) {
    options.ledger = path;
    options.keys = {key};
    const FileIdentity now = identity_of(path);
    if (!checked_ || now != identity_) {
      AuditOptions by_any_key;
      by_any_key.stop = options.stop;
      Result<CheckedLedger> checked = check_ledger(path, by_any_key);
      if (!checked) return tl::unexpected(std::move(checked.error()));
      // A new key has signed nothing until the ledger gets its next entry. If it were pinned, every earlier run would
      // look forged. So no key is pinned until then, and nothing is trusted.
      announced_ = checked->verifies() && checked->book.keys().back() == key && !checked->knows(key);
      if (!announced_) checked->must_be_by({key});
      checked_ = std::make_shared<const CheckedLedger>(std::move(*checked));
      identity_ = now;
    }
    if (announced_) options.keys.clear();
    options.checked = checked_;
    return {};
  }
  // True once: the key had signed nothing when verdicts were given, and has now.
  bool has_begun_to_sign(AuditOptions options, const std::string& path, const PublicKey& key) {
    if (!announced_ || identity_of(path) == identity_) return false;
    return give(options, path, key) && !announced_;
  }

 private:
  std::shared_ptr<const CheckedLedger> checked_;
  FileIdentity identity_{};
  bool announced_ = false;
};

RunVerdict verdict_on(const std::string& path, const AuditOptions& options) {
  RunVerdict verdict;
  const Result<Audit> audit = audit_run(path, options);
  verdict.utc = iso_utc(utc_now_ns());
  if (!audit) {
    verdict.why_none = audit.error();
    return verdict;
  }
  verdict.state = audit->state;
  verdict.where = audit->where;
  verdict.until_s = audit->until_s;
  verdict.until_utc = audit->until_utc;
  verdict.trusted = audit->trusted;
  return verdict;
}

}  // namespace

struct RunAudits::Shared {
  explicit Shared(std::string the_directory) : directory(std::move(the_directory)) {}

  const std::string directory;
  // The jobs' thread alone:
  std::map<std::string, FileIdentity> known;  // of the audited files
  KnownLedger ledger;
  mutable std::mutex mutex;
  // Under the mutex:
  bool busy = false;        // a job waits or is under way
  bool up_to_date = false;  // the newest job found nothing to audit
  std::vector<std::string> tampered;
  std::shared_ptr<const RunVerdicts> verdicts = std::make_shared<const RunVerdicts>();

  void put(const std::string& file, RunVerdict verdict) {
    const std::lock_guard lock(mutex);
    if (verdict.why_none.empty() && verdict.state == AuditState::tampered)
      tampered.push_back(file + " is tampered with: " + verdict.where);
    auto fresh = std::make_shared<RunVerdicts>(*verdicts);
    (*fresh)[file] = std::move(verdict);
    verdicts = std::move(fresh);
  }

  // Forgets all files that are not in the list.
  void keep_only(const std::vector<std::string>& files) {
    const auto gone = [&](const auto& entry) {
      return std::find(files.begin(), files.end(), entry.first) == files.end();
    };
    std::erase_if(known, gone);
    const std::lock_guard lock(mutex);
    if (std::none_of(verdicts->begin(), verdicts->end(), gone)) return;
    auto fresh = std::make_shared<RunVerdicts>(*verdicts);
    std::erase_if(*fresh, gone);
    verdicts = std::move(fresh);
  }

  void put_removed(const std::string& file) {
    {
      const std::lock_guard lock(mutex);
      if (const auto before = verdicts->find(file); before != verdicts->end() && before->second.removed) return;
    }
    RunVerdict verdict;
    verdict.removed = true;
    verdict.why_none = "its file was removed";
    put(file, std::move(verdict));
  }

  // What could not be audited is tried again: nothing of the file says when it can.
  void forget_failures() {
    const std::lock_guard lock(mutex);
    for (const auto& [file, verdict] : *verdicts)
      if (!verdict.why_none.empty()) known.erase(file);
  }

  // Audits the newest run that has no verdict, or whose file has changed. False: there is none.
  bool audit_next(const ListedRuns& runs, const PublicKey& key, const JobThread::Stopping& stopping) {
    std::vector<std::string> files;
    for (auto run = runs.rbegin(); run != runs.rend() && files.size() < kAudited; ++run)
      if (run->state != "recording" && run->state != "ending") files.push_back(run->file);
    keep_only(files);
    AuditOptions options;
    options.stop = stopping;
    if (ledger.has_begun_to_sign(options, ledger_in(directory), key)) known.clear();
    for (const std::string& file : files) {
      const std::string path = directory + "/" + file;
      const FileIdentity identity = identity_of(path);
      if (identity == FileIdentity{}) {  // since it was listed
        known.erase(file);
        put_removed(file);
        continue;
      }
      if (const auto before = known.find(file); before != known.end() && before->second == identity) continue;
      RunVerdict verdict;
      if (auto given = ledger.give(options, ledger_in(directory), key); given)
        verdict = verdict_on(path, options);
      else
        verdict.why_none = given.error();
      if (stopping()) return false;
      known[file] = identity;
      if (identity_of(path) != FileIdentity{}) put(file, std::move(verdict));
      return true;
    }
    return false;
  }
};

RunAudits::RunAudits(std::string directory)
    : shared_(std::make_shared<Shared>(std::move(directory))), jobs_("audits") {}

void RunAudits::turn(std::int64_t now_ns, const std::shared_ptr<const ListedRuns>& runs, const PublicKey& key) {
  const bool looks_again = now_ns >= next_look_ns_;
  {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->busy || (shared_->up_to_date && runs == asked_ && now_ns < next_look_ns_)) return;
    shared_->busy = true;
  }
  asked_ = runs;
  next_look_ns_ = now_ns + kLookAgain_ns;
  jobs_.post([shared = shared_, runs, key, looks_again](const JobThread::Stopping& stopping) {
    lower_priority();
    if (looks_again) shared->forget_failures();
    bool audited = false;
    try {
      audited = shared->audit_next(*runs, key, stopping);
    } catch (const std::exception&) {
      // No memory, for instance: tried again at the next look.
    }
    const std::lock_guard lock(shared->mutex);
    shared->busy = false;
    shared->up_to_date = !audited;
  });
}

std::vector<std::string> RunAudits::take_tampered() {
  const std::lock_guard lock(shared_->mutex);
  return std::exchange(shared_->tampered, {});
}

std::shared_ptr<const RunVerdicts> RunAudits::all() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->verdicts;
}

}  // namespace dwell::record
