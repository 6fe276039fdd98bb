#include "daemon/record/chain_audit.hpp"

#include <algorithm>
#include <utility>

namespace dwell::record {
namespace {

std::string without_path(const std::string& message, const std::string& path) {
  return message.rfind(path + ": ", 0) == 0 ? message.substr(path.size() + 2) : message;
}

}  // namespace

ChainAudit::ChainAudit(Snapshot snapshot, ChainSort sort, bool every_signature)
    : snapshot_(std::move(snapshot)), rows_(snapshot_.database(), sort), every_signature_(every_signature) {}

Result<ChainAudit> ChainAudit::open(const std::string& path, ChainSort sort, bool every_signature,
                                    const std::function<bool()>& stop) {
  Result<Snapshot> snapshot = Snapshot::open(path, stop);
  if (!snapshot) return fails({without_path(snapshot.error(), path), snapshot.error().cause()});
  if (Result<void> tables = check_tables(snapshot->database(), sort); !tables)
    return fails(snapshot->stopped()     ? Failure("reading was given up", Cause::stopped)
                 : snapshot->unchanged() ? std::move(tables.error())
                                         : read_again());
  return ChainAudit(std::move(*snapshot), sort, every_signature);
}

Result<std::optional<ChainReader::Row>> ChainAudit::next() {
  Result<std::optional<ChainReader::Row>> row = rows_.next();
  if (!row) return fails("after " + entry_name(entries_) + ": " + row.error());
  if (!*row) return row;
  const Entry& entry = (*row)->entry;
  if (entry.seq != entries_ + 1)
    return fails(entry_name(entry.seq) + " where " + entry_name(entries_ + 1) + " was expected");
  if (entry.kind.empty() ||
      !std::all_of(entry.kind.begin(), entry.kind.end(), [](char c) { return c > ' ' && c < '\x7f'; }))
    return fails(entry_name(entry.seq) + ": its kind is not in visible ASCII characters");
  head_ = next_head(head_, entry);
  if ((*row)->head != head_) return fails(entry_name(entry.seq) + ": was altered: the chain breaks here");
  entries_ = entry.seq;
  return row;
}

Result<void> ChainAudit::note_holds(const ChainReader::Row& row, const std::string& origin, const PublicKey& key) {
  const std::int64_t seq = row.entry.seq;
  if (row.note.empty()) return fails(entry_name(seq) + ": is not signed");
  const Result<std::string_view> text = key.read(row.note);
  if (!text) return fails("the note on " + entry_name(seq) + ": " + text.error());
  if (every_signature_) {
    if (const auto opened = key.open(row.note); !opened)
      return fails("the note on " + entry_name(seq) + ": " + opened.error());
  }
  const std::string expected = note_text(origin, seq, row.head, row.entry.t_ns, last_note_);
  if (*text != expected) {
    // All but the last two lines: then the note before is gone, or it is another one.
    const std::string front = note_front(origin, seq, row.head, row.entry.t_ns);
    const bool follows_another = text->substr(0, front.size()) == front;
    const std::string found = !follows_another      ? "it signs something else"
                              : last_note_.seq == 0 ? "it follows an earlier note, and there is none"
                                                    : "it does not follow the note on " + entry_name(last_note_.seq);
    return fails("the note on " + entry_name(seq) + ": " + found);
  }
  last_note_ = {seq, note_hash(row.note)};
  if (!every_signature_) unverified_ = row.note;
  ++notes_;
  return {};
}

Result<void> ChainAudit::newest_note_holds(const PublicKey& key) const {
  if (unverified_.empty()) return {};
  const auto opened = key.open(unverified_);
  if (!opened) return fails("the note on " + entry_name(last_note_.seq) + ": " + opened.error());
  return {};
}

Result<void> ChainAudit::finish() {
  if (!snapshot_.altered().empty()) return fails(snapshot_.altered());
  sqlite3* database = snapshot_.database();
  if (first_text(database, "SELECT count(*) FROM note") != std::to_string(notes_)) {
    const std::string seq =
        first_text(database, "SELECT seq FROM note WHERE seq NOT IN (SELECT seq FROM entry) OR text = '' LIMIT 1");
    return fails(seq.empty() ? "the notes cannot be counted" : "a note on entry " + seq + ", where none belongs");
  }
  const std::string sound = first_text(database, "PRAGMA integrity_check(1)");
  if (sound != "ok")
    return fails("the database is damaged: " + (sound.empty() ? sqlite_message(database) : one_line(sound)));
  return {};
}

std::int64_t ChainAudit::last_seq() const {
  const std::string last = first_text(snapshot_.database(), "SELECT max(seq) FROM entry");
  return last.empty() ? 0 : std::strtoll(last.c_str(), nullptr, 10);
}

std::size_t KnownHeads::add(const std::vector<Anchor>& anchors, const std::string& origin) {
  std::size_t added = 0;
  for (const Anchor& anchor : anchors) {
    if (anchor.origin != origin) continue;
    add(anchor.seq, anchor.head, "the anchor of " + anchor.utc);
    ++added;
  }
  return added;
}

Result<void> KnownHeads::fits(std::int64_t seq, const Digest& head) const {
  const auto [begin, end] = heads_.equal_range(seq);
  for (auto known = begin; known != end; ++known)
    if (known->second.head != head)
      return fails("up to " + entry_name(seq) + " this is another chain than the one that " + known->second.source +
                   " knows");
  return {};
}

Result<void> KnownHeads::all_there(std::int64_t last_seq) const {
  if (heads_.empty() || heads_.rbegin()->first <= last_seq) return {};
  return fails("cut after " + entry_name(last_seq) + "; " + heads_.rbegin()->second.source + " knows " +
               entry_name(heads_.rbegin()->first));
}

Result<Anchors> read_all_anchors(const std::vector<std::string>& paths) {
  Anchors together;
  for (const std::string& path : paths) {
    Result<Anchors> some = read_anchors(path);
    if (!some) return some;
    together.all.insert(together.all.end(), some->all.begin(), some->all.end());
    together.skipped += some->skipped;
  }
  return together;
}

}  // namespace dwell::record
