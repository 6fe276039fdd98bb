#include "daemon/record/chain_tail.hpp"

#include <optional>
#include <utility>

namespace dwell::record {

Result<ChainTail> follow_chain(const std::string& path, ChainSort sort, const std::string& origin,
                               const PublicKey& signer) {
  Result<ChainReader> reader = ChainReader::open(path, sort);
  if (!reader) return fails(std::move(reader.error()));
  if (!reader->altered().empty()) return fails(path + ": " + reader->altered() + "; nothing was written");
  ChainTail tail;
  ChainReader::Row noted;  // the last entry with a note, without its body
  NoteLink before;         // the note before that one
  for (;;) {
    Result<std::optional<ChainReader::Row>> row = reader->next();
    if (!row) return fails(std::move(row.error()));
    if (!*row) break;
    const Entry& entry = (*row)->entry;
    const std::string place = path + ": entry " + std::to_string(entry.seq) + ": ";
    if (entry.seq != tail.seq + 1) return fails(place + "expected entry " + std::to_string(tail.seq + 1));
    tail.seq = entry.seq;
    tail.head = next_head(tail.head, entry);
    if ((*row)->head != tail.head) return fails(place + "the chain does not hold");
    if ((*row)->note.empty()) {
      if (entry.kind != "signature") noted.note.clear();
      continue;
    }
    before = std::exchange(tail.note, {entry.seq, note_hash((*row)->note)});
    noted = std::move(**row);
    noted.entry.body.clear();
  }
  if (tail.seq == 0) return tail;
  if (noted.note.empty()) return fails(path + ": its last entries are not signed");
  const Result<std::string> text = signer.open(noted.note);
  const std::string place = path + ": the note on entry " + std::to_string(noted.entry.seq) + ": ";
  if (!text) return fails(place + text.error());
  if (*text != note_text(origin, noted.entry.seq, noted.head, noted.entry.t_ns, before))
    return fails(place + "it signs something else");
  return tail;
}

}  // namespace dwell::record
