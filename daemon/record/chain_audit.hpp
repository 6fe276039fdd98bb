// Follows the chain of a file from its first entry to its last. Checks all that does not depend on the bodies of the
// entries. For audit.hpp.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/record/anchor.hpp"
#include "daemon/record/chain_tables.hpp"
#include "daemon/record/snapshot.hpp"

namespace dwell::record {

[[nodiscard]] inline std::string entry_name(std::int64_t seq) { return "entry " + std::to_string(seq); }

// Bound to one thread. A failure names the place and what was found there, without the path.
class ChainAudit {
 public:
  // every_signature: note_holds() verifies each signature, 0.1 ms a note and most of an audit's time. Otherwise only
  // newest_note_holds() verifies one. That is enough, since each note holds the hash of the note before it. stop: as
  // Snapshot's. After it has said true, a failure does not tell of the file: Cause::stopped here, stopped() later.
  [[nodiscard]] static Result<ChainAudit> open(const std::string& path, ChainSort sort, bool every_signature,
                                               const std::function<bool()>& stop);

  // The next entry. Fails if its seq or head does not follow from those before.
  [[nodiscard]] Result<std::optional<ChainReader::Row>> next();
  // Checks that this entry has a note, which signs this entry of this chain, follows the previous note, and is by
  // `key`.
  [[nodiscard]] Result<void> note_holds(const ChainReader::Row& row, const std::string& origin, const PublicKey& key);
  // Verifies the signature of the newest note, which covers all notes before it. `key`: the one key of all of them.
  // Does nothing if note_holds() has verified each.
  [[nodiscard]] Result<void> newest_note_holds(const PublicKey& key) const;
  // Call after the last entry. Checks that the file holds nothing else, and that SQLite finds it sound.
  [[nodiscard]] Result<void> finish();

  // false: the file changed while it was read; read it again.
  [[nodiscard]] bool unchanged() const noexcept { return snapshot_.unchanged(); }
  [[nodiscard]] bool stopped() const noexcept { return snapshot_.stopped(); }
  [[nodiscard]] std::int64_t entries() const noexcept { return entries_; }  // so far
  [[nodiscard]] const Digest& head() const noexcept { return head_; }       // of the last one so far
  [[nodiscard]] std::int64_t last_seq() const;                              // as the file claims; for progress

 private:
  ChainAudit(Snapshot snapshot, ChainSort sort, bool every_signature);

  Snapshot snapshot_;
  ChainRows rows_;
  bool every_signature_;
  std::int64_t entries_ = 0, notes_ = 0;
  NoteLink last_note_;
  std::string unverified_;  // the text of the last note; empty: there is none whose signature was not verified
  Digest head_{};
};

// Heads that an anchor or the ledger knows.
class KnownHeads {
 public:
  void add(std::int64_t seq, const Digest& head, std::string source) {
    heads_.emplace(seq, Known{head, std::move(source)});
  }
  // Adds the anchors of this chain. Returns how many there are.
  std::size_t add(const std::vector<Anchor>& anchors, const std::string& origin);
  // Fails if another head is known for this entry.
  [[nodiscard]] Result<void> fits(std::int64_t seq, const Digest& head) const;
  // Fails if a later entry is known than the last one of the file.
  [[nodiscard]] Result<void> all_there(std::int64_t last_seq) const;

 private:
  struct Known {
    Digest head;
    std::string source;  // "the anchor of 2026-11-23T03:12:17.250000Z", "the ledger"
  };
  std::multimap<std::int64_t, Known> heads_;
};

// Reads files of anchors. Fails as read_anchors().
[[nodiscard]] Result<Anchors> read_all_anchors(const std::vector<std::string>& paths);

}  // namespace dwell::record
