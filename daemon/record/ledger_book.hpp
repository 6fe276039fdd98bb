// Reads the entries of a ledger one after the other, and checks that each fits those before it. Does not check chain
// and notes. docs/run-file.md, "The ledger".
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/digest.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// A run as the ledger knows it.
struct LedgerRun {
  struct End {
    std::string head;  // hexadecimal; empty: nothing was committed
    std::int64_t seq = 0;
    std::string state;  // "closed", "cut off"
    std::string utc;
  };
  struct Deleted {
    std::string why, utc;
  };
  std::int64_t run = 0;
  std::string id, file, label, start_utc, previous_head;
  std::string vkey;  // that signs it
  std::optional<End> end;
  std::optional<Deleted> deleted;
  std::vector<PersonalSignature> signatures;
};

// Bound to one thread. Memory: some 500 bytes a run.
class LedgerBook {
 public:
  // Takes the next entry. Fails with what does not fit; then the book is as before.
  [[nodiscard]] Result<void> take(const Entry& entry);

  [[nodiscard]] bool empty() const noexcept { return keys_.empty(); }
  [[nodiscard]] const std::string& id() const noexcept { return id_; }
  [[nodiscard]] std::string origin() const { return "dwell/ledger/" + id_; }
  // The keys in their order; the last one signs the next entry.
  [[nodiscard]] const std::vector<PublicKey>& keys() const noexcept { return keys_; }
  // How many of them have signed an entry: all, or all but the last if the last entry changed the key.
  [[nodiscard]] std::size_t signers() const noexcept { return keys_.size() - (key_just_changed_ ? 1 : 0); }
  // The key that signed the last entry. Not if empty().
  [[nodiscard]] const PublicKey& last_signer() const { return keys_[signers() - 1]; }
  [[nodiscard]] const std::map<std::int64_t, LedgerRun>& runs() const noexcept { return runs_; }
  [[nodiscard]] std::int64_t next_run() const noexcept { return static_cast<std::int64_t>(runs_.size()) + 1; }
  [[nodiscard]] const std::string& newest_head() const noexcept { return newest_head_; }
  [[nodiscard]] std::int64_t running() const noexcept { return running_; }

 private:
  struct Taker;
  std::string id_, newest_head_;
  std::vector<PublicKey> keys_;
  std::map<std::int64_t, LedgerRun> runs_;  // 1, 2, 3 …
  std::int64_t running_ = 0;
  bool key_just_changed_ = false;
};

// All entries of a ledger, without a check of chain and notes; again where the service writes meanwhile. Reads the
// whole file; any thread. Fails with the file and what does not fit.
[[nodiscard]] Result<LedgerBook> read_book(const std::string& path);

// Bodies of the entries. `utc`: now.
[[nodiscard]] std::string ledger_opens(const std::string& id, const PublicKey& key, const std::string& utc);
[[nodiscard]] std::string ledger_key(const PublicKey& next, const std::string& utc);
[[nodiscard]] std::string ledger_begins(const RunHeader& header, const std::string& file, const std::string& utc);
[[nodiscard]] std::string ledger_ends(std::int64_t run, const LedgerRun::End& end);
[[nodiscard]] std::string ledger_deleted(std::int64_t run, const std::string& head, const std::string& why,
                                         const std::string& utc);
[[nodiscard]] std::string ledger_signed(std::int64_t run, const PersonalSignature& signature, const std::string& utc);

}  // namespace dwell::record
