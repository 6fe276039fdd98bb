// Checks chain, notes and keys of a ledger. For audit.hpp.
#pragma once

#include <string>
#include <vector>

#include "daemon/record/audit.hpp"
#include "daemon/record/ledger_book.hpp"

namespace dwell::record {

struct CheckedLedger {
  LedgerBook book;     // up to where it is broken
  std::string broken;  // the place and what was found; empty: the ledger verifies

  [[nodiscard]] bool verifies() const noexcept { return broken.empty(); }
  // One of these keys must have signed the ledger; otherwise it is broken. Empty: any key may.
  void must_be_by(const std::vector<PublicKey>& keys);
  // Whether the key has signed entries of this ledger.
  [[nodiscard]] bool knows(const PublicKey& key) const;
  // nullptr: the ledger has no run of this number, or of this file name.
  [[nodiscard]] const LedgerRun* find(std::int64_t run) const;
  [[nodiscard]] const LedgerRun* find(const std::string& file) const;
};

// Fails only if the ledger or an anchor file does not exist or cannot be read at all, if the ledger is of a newer
// format, or if options.stop says so.
[[nodiscard]] Result<CheckedLedger> check_ledger(const std::string& path, const AuditOptions& options);

// "the key asked for", for messages.
[[nodiscard]] std::string asked_for(const std::vector<PublicKey>& keys);

// Fails where there is no readable file at `path`.
[[nodiscard]] Result<void> readable_file(const std::string& path);

}  // namespace dwell::record
