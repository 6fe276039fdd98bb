// The end of a chain to which somebody wants to append.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/chain_tables.hpp"

namespace dwell::record {

struct ChainTail {
  std::int64_t seq = 0;  // of the last entry; 0: there is none
  Digest head{};         // its head
  NoteLink note;         // the last note
};

// Follows the chain of a file from its start: the time goes with its size. Fails with the place if the chain does not
// hold, if the last note is not by `signer`, if entries other than signatures come after it, or if the -wal has damage
// that no crash causes. `origin`: the first line of the file's notes.
[[nodiscard]] Result<ChainTail> follow_chain(const std::string& path, ChainSort sort, const std::string& origin,
                                             const PublicKey& signer);

}  // namespace dwell::record
