// A ledger whose chain, notes and keys were checked. For audit.hpp.
#pragma once

#include <string>

#include "daemon/record/audit.hpp"
#include "daemon/record/ledger_book.hpp"

namespace dwell::record {

struct CheckedLedger {
  LedgerBook book;     // up to where it is broken
  std::string broken;  // the place and what was found; empty: the ledger verifies

  [[nodiscard]] bool verifies() const noexcept { return broken.empty(); }
  [[nodiscard]] bool knows(const PublicKey& key) const;
  // nullptr: it does not know a run of this number.
  [[nodiscard]] const LedgerRun* find(std::int64_t run) const;
};

// Fails only where the file is not there or cannot be read at all, or an anchor file cannot.
[[nodiscard]] Result<CheckedLedger> check_ledger(const std::string& path, const AuditOptions& options);

// Fails where there is no readable file at `path`.
[[nodiscard]] Result<void> readable_file(const std::string& path);

}  // namespace dwell::record
