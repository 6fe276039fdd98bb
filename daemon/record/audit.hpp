// Checks that a run file is as it was recorded: the chain of its entries, the notes that sign it, its place in the
// ledger. Needs neither service nor private key, and alters no byte of what it checks.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/keys.hpp"

namespace dwell::record {

enum class AuditState : std::uint8_t {
  intact,    // closed, and nothing was altered
  open,      // no end: still recorded, or cut off; what there is was not altered
  tampered,  // altered, or not readable as what it claims to be
};

struct Audit {
  std::string file;
  AuditState state = AuditState::tampered;
  std::optional<double> until_s;  // of one that is open: valid up to here, on the run's own axis
  std::string until_utc;
  std::string where;     // of one that is tampered: the place and what was found there
  std::int64_t run = 0;  // the ledger's number; 0: not known
  std::string id;
  std::uint64_t samples = 0;
  std::string head;                     // of the last entry, hexadecimal
  std::string key;                      // fingerprint of the key that signs it
  bool trusted = false;                 // it is the key asked for, or the ledger's
  std::vector<std::string> signatures;  // one line each: who, what for, when, by which key
};

struct AuditOptions {
  std::optional<PublicKey> key;          // pinned: the file must be signed by it
  std::string ledger;                    // path of a ledger; empty: none
  std::vector<std::string> anchors;      // files of heads kept elsewhere
  std::function<void(double)> progress;  // 0 … 1; empty: none
};

// Never fails: what cannot be read is tampered, with the reason, but a file that is not there.
[[nodiscard]] Result<Audit> audit_run(const std::string& path, const AuditOptions& options);

struct LedgerAudit {
  bool unbroken = false;
  std::string where;                 // what is broken
  std::vector<std::string> deleted;  // runs that retention has deleted, one line each
  std::vector<std::string> missing;  // runs that should be in `directory` and are not
};

// The ledger itself, and whether every run that it knows is in `directory` or was deleted by retention.
[[nodiscard]] Result<LedgerAudit> audit_ledger(const std::string& path, const std::string& directory,
                                               const AuditOptions& options);

}  // namespace dwell::record
