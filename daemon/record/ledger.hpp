// The ledger of a recording directory: a chained, signed file that knows every run, so that a removed one shows. It
// also knows the keys, what retention has deleted, and personal signatures. docs/run-file.md, "The ledger".
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "daemon/record/anchor.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// Bound to one thread. Every call commits before it returns, and so waits for the disk. A failure leaves the ledger as
// it was.
class Ledger {
 public:
  // `directory`/ledger.dwell-ledger, made where there is none.
  [[nodiscard]] static Result<Ledger> open(const std::string& directory, const SigningKey& key);
  Ledger(Ledger&&) noexcept;
  Ledger& operator=(Ledger&&) noexcept;
  ~Ledger();

  // The number that the next run takes, and the final head of the newest run that has one (hexadecimal; empty: none).
  [[nodiscard]] std::int64_t next_run() const noexcept;
  [[nodiscard]] const std::string& newest_head() const noexcept;
  // A run that has begun and not ended: after a crash, the one that was cut off. 0: none.
  [[nodiscard]] std::int64_t running() const noexcept;
  // Of the last entry; its utc is empty. To be anchored with the heads of the runs.
  [[nodiscard]] Anchor head() const;

  // Fails where `header` does not take next_run() and newest_head(), or another run has not ended.
  [[nodiscard]] Result<void> run_begins(const RunHeader& header, const std::string& file);
  // state: "closed", or "cut off" where a crash ended it; then head is that of its last committed entry, and empty with
  // seq 0 where nothing was committed.
  [[nodiscard]] Result<void> run_ends(std::int64_t run, const std::string& head, std::int64_t seq,
                                      const std::string& state);
  [[nodiscard]] Result<void> run_deleted(std::int64_t run, const std::string& head, const std::string& why);
  [[nodiscard]] Result<void> run_signed(std::int64_t run, const PersonalSignature& signature);
  // From here on another key signs. Signed by the old one. This ledger then takes nothing more: open it with the new
  // key.
  [[nodiscard]] Result<void> key_changes(const PublicKey& next);

 private:
  struct Impl;
  explicit Ledger(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
