// A person's signature under a run that has ended: its words, and the entry that holds it. docs/run-file.md, "Personal
// signatures". Who asks is not checked here: the service does it by the socket, a person by having the key.
#pragma once

#include <string>

#include "daemon/record/digest.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// Bytes of a name, a meaning or a reason at most: they stand in tables and on a printed page.
inline constexpr std::size_t kMaxWords = 500;

// Fails with what is wrong with name, meaning or reason: each is one line of UTF-8, and only the reason may be empty.
[[nodiscard]] Result<void> check_words(const PersonalSignature& signature);

// The text that a key of the person's own signs; `run`: the run's id.
[[nodiscard]] std::string signed_lines(const std::string& run, const PersonalSignature& signature);

// The instant now as ISO 8601, UTC, whole seconds.
[[nodiscard]] std::string utc_now();

// What was signed: the run's number on the ledger (0: a child file) and the entry as it stands in the file.
struct Signed {
  std::int64_t run = 0;
  PersonalSignature signature;
};

// Adds the entry to the run file at `path`, with the words (name, meaning, reason) and, where the service vouches, the
// person of `words`; all else is filled in here. `key` signs: the service's, or the person's own. Fails with the reason
// where the run has not ended or the file is not what it was; then the file is as it was. Follows the whole chain
// first: as slow as reading the file. Waits for the disk.
[[nodiscard]] Result<Signed> sign_run(const std::string& path, const PersonalSignature& words, const SigningKey& key);

}  // namespace dwell::record
