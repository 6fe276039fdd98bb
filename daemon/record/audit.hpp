// Checks that a run file is as it was recorded: the chain of its entries, the notes that sign it, its place in the
// ledger. Needs neither the service nor a private key, and alters no byte of the files.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/keys.hpp"

namespace dwell::record {

enum class AuditState : std::uint8_t {
  intact,    // closed, and nothing was altered
  open,      // without an end: still recorded, or cut off; no entry was altered
  tampered,  // altered, or not readable as a run file
};

[[nodiscard]] const char* to_string(AuditState state) noexcept;  // "intact", "open", "tampered"

// A person's signature that holds.
struct AuditedSignature {
  std::string text;      // one line: by which key, then who, what for, when
  std::string key;       // fingerprint of the person's own key; empty: the service countersigned
  bool trusted = false;  // the person's key is pinned; of the service's countersignature: the file's key is trusted
};

struct Audit {
  std::string file;
  AuditState state = AuditState::tampered;
  std::optional<double> until_s;  // of an open file: it is valid so far, s since the `t_ns` of the `run` entry
  std::string until_utc;
  std::string where;     // of a tampered file: the place and what was found there
  bool unknown = false;  // the ledger does not know the run
  std::int64_t run = 0;  // the ledger's number; 0: not known
  std::string id;
  std::uint64_t samples = 0;
  std::string head;        // of the last entry, hexadecimal
  std::string key;         // fingerprint of the key that signs it
  bool trusted = false;    // a pinned key, or one that the ledger connects with a pinned key
  bool of_ledger = false;  // the ledger knows the key; without a pinned key this proves nothing
  std::vector<AuditedSignature> signatures;
  std::string broken_ledger;  // why the ledger asked for does not verify: nothing was compared with it; empty: it does
  std::size_t anchored_heads = 0;        // anchors of this run; all of them hold unless the file is tampered
  std::size_t skipped_anchor_lines = 0;  // Anchors::skipped
};

// The key and whether it is trusted: "key 7c0e 1969 … trusted", "key 7c0e 1969 … not trusted (known to this ledger)".
[[nodiscard]] std::string key_verdict(const Audit& audit);

struct CheckedLedger;

struct AuditOptions {
  std::vector<PublicKey> keys;  // pinned: one of them must have signed; empty: no key is trusted
  std::string ledger;           // path of a ledger; empty: none
  std::vector<PublicKey> persons =
      {};  // pinned keys of persons: of signatures by their own keys only these are trusted
  // The result of check_ledger() on `ledger` with these keys and anchors (ledger_check.hpp), for audits of several
  // files. Null: the ledger is checked for this audit alone.
  std::shared_ptr<const CheckedLedger> checked = {};
  std::vector<std::string> anchors;      // files of heads kept elsewhere
  std::function<void(double)> progress;  // 0 … 1; empty: none
  // Verify the signature of each note by itself. Not needed: the newest covers all before it, and where it does not
  // hold all are looked at. The signatures of a ledger are always all verified.
  bool every_signature = false;
  // Asked before each page of a run or a ledger is read. true: the audit is given up, and audit_run() and
  // check_ledger() fail with kAuditStopped. Empty: it is never given up.
  std::function<bool()> stop = {};
};
inline constexpr const char* kAuditStopped = "the audit was given up";

// A file that is no run file counts as tampered, with the reason. A ledger, a -wal and the reserve of a recording
// directory are told by name and content: for these the audit fails and says what the file is. It fails likewise for a
// file of a newer format. It fails too if the run file, the ledger or an anchor file does not exist or may not be read,
// or if a writer altered the run file during each of kReadTries passes, or if the service has not entered the run into
// the ledger yet.
[[nodiscard]] Result<Audit> audit_run(const std::string& path, const AuditOptions& options);

struct LedgerAudit {
  bool unbroken = false;
  bool trusted = false;              // a pinned key has signed it
  std::string key;                   // fingerprint of the key that signs it now; empty: it has no entry
  std::string where;                 // what is broken
  std::vector<std::string> deleted;  // runs entered as deleted, one line each: by retention, or they never had a file
  std::vector<std::string> missing;  // runs that should be in `directory` and are not
  std::size_t anchored_heads = 0;    // anchors of this ledger; all of them hold if it is unbroken
  std::size_t foreign_anchors = 0;   // lines of ledgers other than this one: nothing is compared with them
  std::size_t skipped_anchor_lines = 0;  // Anchors::skipped
};

// Checks the ledger itself, and that each run it knows is in `directory` or is entered as deleted. Fails if the ledger
// or an anchor file does not exist or cannot be read.
[[nodiscard]] Result<LedgerAudit> audit_ledger(const std::string& path, const std::string& directory,
                                               const AuditOptions& options);

}  // namespace dwell::record
