#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "daemon/record/audit.hpp"
#include "daemon/record/chain_audit.hpp"
#include "daemon/record/file_identity.hpp"
#include "daemon/record/ledger_check.hpp"
#include "daemon/record/snapshot.hpp"

namespace dwell::record {
namespace {

std::string name_of(const LedgerRun& run) {
  return "run " + std::to_string(run.run) + " (" + run.file + ", begun " + run.start_utc + ")";
}

// Empty: the run's file is in its place. Only its first entry is read: its own audit says what is wrong with the rest.
std::string missing(const LedgerRun& run, const std::string& directory) {
  // The name alone, without folders: a ledger must not lead out of the directory.
  const std::filesystem::path path = std::filesystem::path(directory) / std::filesystem::path(run.file).filename();
  std::error_code code;
  if (run.file.empty() || !std::filesystem::is_regular_file(path, code)) return name_of(run) + " is not there";
  const auto first = read_until_whole([&]() -> Result<std::optional<ChainReader::Row>> {
    return ChainReader::open(path.string(), ChainSort::run).and_then([](ChainReader reader) { return reader.next(); });
  });
  if (!first) return name_of(run) + ": that file cannot be read: " + first.error();
  if (!*first) return run.end && !run.end->head.empty() ? name_of(run) + ": that file holds no entry" : std::string();
  const Result<RunHeader> header = parse_run_header((*first)->entry.body);
  if (!header) return name_of(run) + ": that file cannot be read: entry 1: " + header.error();
  return header->id == run.id ? std::string() : name_of(run) + ": that file holds another run";
}

// Runs that an anchor knows and the ledger does not: file and ledger entry were removed. And runs that have entries by
// an anchor, and are deleted without one by the ledger: their file could not be read when the service entered its end.
std::vector<std::string> unknown(const LedgerBook& book, const std::vector<Anchor>& anchors) {
  static constexpr std::string_view kFront = "dwell/run/";
  std::map<std::string, const LedgerRun*> known;
  for (const auto& [number, run] : book.runs()) known.emplace(run.id, &run);
  std::set<std::string> others;
  for (const Anchor& anchor : anchors) {
    if (anchor.origin.rfind(kFront, 0) != 0) continue;
    const auto run = known.find(anchor.origin.substr(kFront.size()));
    if (run == known.end())
      others.insert("run " + anchor.origin.substr(kFront.size()) + ", which only the anchors know");
    else if (run->second->deleted && run->second->end && run->second->end->seq == 0)
      others.insert(name_of(*run->second) + " has no entry by the ledger; the anchors know one");
  }
  return {others.begin(), others.end()};
}

// The ledger as it is later than the one that is audited. Retention tells the ledger before it removes a file, and it
// may do so during the audit.
class Later {
 public:
  Later(const std::string& path, const AuditOptions& options) : path_(path), options_(options) {}

  // The run, if the ledger has it as deleted by now; null: it has not. Reads the ledger where it has changed.
  [[nodiscard]] const LedgerRun* deleted(std::int64_t number) {
    if (const FileIdentity now = identity_of(path_); now != identity_) {
      identity_ = now;
      Result<CheckedLedger> checked = check_ledger(path_, options_);
      ledger_ = checked && checked->verifies() ? std::move(*checked) : CheckedLedger();
    }
    const LedgerRun* const run = ledger_.find(number);
    return run != nullptr && run->deleted ? run : nullptr;
  }

 private:
  const std::string& path_;
  const AuditOptions& options_;
  FileIdentity identity_{};
  CheckedLedger ledger_;
};

}  // namespace

Result<LedgerAudit> audit_ledger(const std::string& path, const std::string& directory, const AuditOptions& options) {
  std::shared_ptr<const CheckedLedger> ledger = options.checked;
  if (!ledger) {
    Result<CheckedLedger> checked = check_ledger(path, options);
    if (!checked) return tl::unexpected(std::move(checked.error()));
    ledger = std::make_shared<const CheckedLedger>(std::move(*checked));
  }
  const Result<Anchors> anchors = read_all_anchors(options.anchors);
  if (!anchors) return tl::unexpected(anchors.error());
  LedgerAudit audit;
  audit.unbroken = ledger->verifies();
  audit.where = ledger->broken;
  if (!ledger->book.empty()) audit.key = ledger->book.last_signer().fingerprint();
  audit.trusted = audit.unbroken && !options.keys.empty();  // with keys that did not sign it, it is broken
  std::size_t done = 0;
  Later later(path, options);
  for (const auto& [number, run] : ledger->book.runs()) {
    if (options.progress)
      options.progress(static_cast<double>(done++) / static_cast<double>(ledger->book.runs().size()));
    std::string line = run.deleted ? std::string() : missing(run, directory);
    const LedgerRun* deleted = line.empty() ? &run : later.deleted(number);
    if (deleted != nullptr && deleted->deleted)
      audit.deleted.push_back(name_of(run) + " was deleted at " + deleted->deleted->utc + ": " + deleted->deleted->why);
    else if (!line.empty())
      audit.missing.push_back(std::move(line));
  }
  for (std::string& line : unknown(ledger->book, anchors->all)) audit.missing.push_back(std::move(line));
  for (const Anchor& anchor : anchors->all) {
    if (anchor.origin.rfind("dwell/ledger/", 0) != 0) continue;
    ++(anchor.origin == ledger->book.origin() ? audit.anchored_heads : audit.foreign_anchors);
  }
  audit.skipped_anchor_lines = anchors->skipped;
  if (options.progress) options.progress(1.0);
  return audit;
}

}  // namespace dwell::record
