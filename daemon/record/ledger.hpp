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

// Bound to one thread. Every call commits before it returns, so it waits for the disk. After a failure the ledger is as
// before.
class Ledger {
 public:
  // ledger_in(directory), made where there is none.
  [[nodiscard]] static Result<Ledger> open(const std::string& directory, const SigningKey& key);
  Ledger(Ledger&&) noexcept;
  Ledger& operator=(Ledger&&) noexcept;
  ~Ledger();

  // The number that the next run takes, and the final head of the newest run that has one (hexadecimal; empty: none).
  [[nodiscard]] std::int64_t next_run() const noexcept;
  [[nodiscard]] const std::string& newest_head() const noexcept;
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
  // Starts the log, with up to three waits for the disk. The next entry then takes one.
  [[nodiscard]] Result<void> begin_log();
  // As ChainWriter::merge_log(). Any thread may call it; entries written meanwhile wait for it.
  [[nodiscard]] Result<void> merge_log();
  // How a run's file ends. state: "closed", or "cut off" after a crash. Then `head` is that of its last committed
  // entry; if nothing was committed, it is empty and seq 0.
  struct Ending {
    std::int64_t run = 0;
    std::string head;
    std::int64_t seq = 0;
    std::string state;
  };
  [[nodiscard]] Result<void> run_ends(const Ending& ended);
  // A run ends and the next one begins, entered with one wait for the disk. `header` holds the head of the run that
  // ends.
  [[nodiscard]] Result<void> run_follows(const Ending& ended, const RunHeader& header, const std::string& file);
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
