// The ledger of a recording directory: a chained, signed file that lists every run, so that a removed run is noticed.
// It also lists the keys, the runs that retention deleted, and personal signatures. docs/run-file.md, "The ledger".
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "daemon/record/anchor.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// Questions may come from any thread, and never wait. Entries commit before they return, so they wait for the disk;
// they may come from any thread, and wait for each other. After a failure the ledger is as before.
class Ledger {
 public:
  // ledger_in(directory), made where there is none.
  [[nodiscard]] static Result<Ledger> open(const std::string& directory, const SigningKey& key);
  Ledger(Ledger&&) noexcept;
  Ledger& operator=(Ledger&&) noexcept;
  ~Ledger();

  // The number that the next run takes, and the final head of the newest run that has one (hexadecimal; empty: none).
  [[nodiscard]] std::int64_t next_run() const noexcept;
  [[nodiscard]] std::string newest_head() const;
  // The name of a run's file; empty: the ledger does not know this run.
  [[nodiscard]] std::string file_of(std::int64_t run) const;
  // Whether the run had entries and is entered as deleted.
  [[nodiscard]] bool is_deleted(std::int64_t run) const;
  // A run that has begun and not ended: after a crash, the one that was cut off. 0: none.
  [[nodiscard]] std::int64_t running() const noexcept;
  // The head of the last entry, to be anchored with the heads of the runs; its utc is empty.
  [[nodiscard]] Anchor head() const;

  // Fails if `header` does not hold next_run() and newest_head(), or if another run has not ended.
  [[nodiscard]] Result<void> run_begins(const RunHeader& header, const std::string& file);
  // As ChainWriter::merge_log().
  [[nodiscard]] Result<void> merge_log();
  // How a run's file ends. state: "closed", or "cut off" after a crash. Then `head` is that of its last committed
  // entry; if the file is gone or cannot be read, it is empty and seq 0.
  struct Ending {
    std::int64_t run = 0;
    std::string head;
    std::int64_t seq = 0;
    std::string state;
  };
  [[nodiscard]] Result<void> run_ends(const Ending& ended);
  [[nodiscard]] Result<void> run_deleted(std::int64_t run, const std::string& why);
  [[nodiscard]] Result<void> run_signed(std::int64_t run, const PersonalSignature& signature);
  // Adds a change of keys, signed by the old key. Afterwards this object takes nothing more: open the ledger with the
  // new key.
  [[nodiscard]] Result<void> key_changes(const PublicKey& next);

 private:
  struct Impl;
  explicit Ledger(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dwell::record
