// Follows the chain of a file from its first entry to its last, and checks everything about the file that does not
// depend on what the entries say. For audit.hpp.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/anchor.hpp"
#include "daemon/record/chain_tables.hpp"
#include "daemon/record/snapshot.hpp"

namespace dwell::record {

// Bound to one thread. Every failure is the place and what was found there, without the path.
class ChainAudit {
 public:
  [[nodiscard]] static Result<ChainAudit> open(const std::string& path, ChainSort sort);

  // The next entry, whose seq and head follow from those before.
  [[nodiscard]] Result<std::optional<ChainReader::Row>> next();
  // That the note on this entry is there, signs this entry of this chain, follows the note before, and is by `key`.
  [[nodiscard]] Result<void> note_holds(const ChainReader::Row& row, const std::string& origin, const PublicKey& key);
  // After the last entry: that there is nothing else in the file, and that SQLite finds it sound.
  [[nodiscard]] Result<void> finish();

  // Whether what was found is of one state of the file. false: read again.
  [[nodiscard]] bool unchanged() const noexcept { return snapshot_.unchanged(); }
  [[nodiscard]] std::int64_t entries() const noexcept { return entries_; }  // so far
  [[nodiscard]] const Digest& head() const noexcept { return head_; }       // of the last one so far
  [[nodiscard]] std::int64_t last_seq() const;                              // as the file claims; for progress

 private:
  explicit ChainAudit(Snapshot snapshot);

  Snapshot snapshot_;
  ChainRows rows_;
  std::int64_t entries_ = 0, notes_ = 0, last_note_ = 0;
  Digest head_{};
};

// Heads that something outside the file knows: an anchor, the ledger.
class KnownHeads {
 public:
  void add(std::int64_t seq, const Digest& head, std::string source) {
    heads_.emplace(seq, Known{head, std::move(source)});
  }
  // Of all anchors those of this chain.
  void add(const std::vector<Anchor>& anchors, const std::string& origin);
  // Fails where the head of this entry is known, and is another one.
  [[nodiscard]] Result<void> fits(std::int64_t seq, const Digest& head) const;
  // Fails where an entry after the last one of the file is known.
  [[nodiscard]] Result<void> all_there(std::int64_t last_seq) const;

 private:
  struct Known {
    Digest head;
    std::string source;  // "the anchor of 2026-11-23T03:12:17Z"
  };
  std::multimap<std::int64_t, Known> heads_;
};

// Of files of anchors. Fails as read_anchors().
[[nodiscard]] Result<std::vector<Anchor>> read_all_anchors(const std::vector<std::string>& paths);

// How often a file is read anew because its writer closed it meanwhile.
inline constexpr int kAuditTries = 5;

}  // namespace dwell::record
