#include "daemon/record/ledger_check.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <utility>

#include "daemon/record/chain_audit.hpp"

namespace dwell::record {
namespace {

// Takes the next entry into the book, then checks its note. last_signer() is the key that must have signed it: a change
// of keys is signed by the old key.
Result<void> take(ChainAudit& chain, CheckedLedger& ledger, KnownHeads& known, const std::vector<Anchor>& anchors,
                  const ChainReader::Row& row) {
  const std::string place = entry_name(row.entry.seq) + ": ";
  const bool first = ledger.book.empty();
  if (Result<void> taken = ledger.book.take(row.entry); !taken) return tl::unexpected(place + taken.error());
  if (first) known.add(anchors, ledger.book.origin());
  if (Result<void> fits = known.fits(row.entry.seq, row.head); !fits) return fits;
  return chain.note_holds(row, ledger.book.origin(), ledger.book.last_signer());
}

Result<void> walk(ChainAudit& chain, CheckedLedger& ledger, const std::vector<Anchor>& anchors) {
  KnownHeads known;
  for (;;) {
    const auto row = chain.next();
    if (!row) return tl::unexpected(row.error());
    if (!*row) break;
    if (Result<void> taken = take(chain, ledger, known, anchors, **row); !taken) return taken;
  }
  if (Result<void> there = known.all_there(chain.entries()); !there) return there;
  if (ledger.book.empty()) return tl::unexpected(std::string("it has no entry; is its -wal missing?"));
  return chain.finish();
}

}  // namespace

bool CheckedLedger::knows(const PublicKey& key) const {
  // A key that only the last entry announces has signed nothing: whoever knows its public half can announce it.
  const auto end = book.keys().begin() + static_cast<std::ptrdiff_t>(book.signers());
  return std::find(book.keys().begin(), end, key) != end;
}

void CheckedLedger::must_be_by(const std::vector<PublicKey>& keys) {
  const auto known = [this](const PublicKey& key) { return knows(key); };
  if (verifies() && !keys.empty() && std::none_of(keys.begin(), keys.end(), known))
    broken = "signed by " + book.last_signer().fingerprint() + ", not by " + asked_for(keys);
}

const LedgerRun* CheckedLedger::find(std::int64_t run) const {
  const auto found = book.runs().find(run);
  return found == book.runs().end() ? nullptr : &found->second;
}

const LedgerRun* CheckedLedger::find(const std::string& file) const {
  for (const auto& [number, run] : book.runs())
    if (run.file == file) return &run;
  return nullptr;
}

std::string asked_for(const std::vector<PublicKey>& keys) {
  return keys.size() == 1 ? "the key asked for" : "one of the keys asked for";
}

Result<void> readable_file(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return tl::unexpected(path + ": " + std::strerror(errno));
  if (!S_ISREG(status.st_mode)) return tl::unexpected(path + ": is no file");
  if (::access(path.c_str(), R_OK) != 0) return tl::unexpected(path + ": " + std::strerror(errno));
  return {};
}

Result<CheckedLedger> check_ledger(const std::string& path, const AuditOptions& options) {
  if (Result<void> there = readable_file(path); !there) return tl::unexpected(std::move(there.error()));
  const Result<Anchors> anchors = read_all_anchors(options.anchors);
  if (!anchors) return tl::unexpected(anchors.error());
  for (int tries = 1;; ++tries) {
    CheckedLedger ledger;
    Result<ChainAudit> chain = ChainAudit::open(path, ChainSort::ledger, true, options.stop);
    const Result<void> sound = chain ? walk(*chain, ledger, anchors->all) : tl::unexpected(chain.error());
    if (chain ? chain->stopped() : chain.error().cause() == Cause::stopped)
      return fails({kAuditStopped, Cause::stopped});
    const bool whole = chain ? chain->unchanged() : chain.error().cause() != Cause::read_again;
    if (!whole && tries < kReadTries) continue;
    if (!sound && sound.error().cause() == Cause::newer)
      return fails({path + ": cannot be audited: " + sound.error(), Cause::newer});
    if (!sound) ledger.broken = sound.error();
    ledger.must_be_by(options.keys);
    return ledger;
  }
}

}  // namespace dwell::record
