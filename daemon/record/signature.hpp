// Adds a person's signature to the end of a closed run file. Either the service vouches for the person with its note,
// or the person signs with a key of their own. docs/run-file.md, "`signature` entries".
#pragma once

#include <string>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// The lines that a person's own key signs, each with its newline. Fails if a member is not UTF-8 or holds a
// control character, a newline for instance.
[[nodiscard]] Result<std::string> signature_text(const std::string& run_id, const PersonalSignature& signature);

// Waits for the service, which writes a run's end up to a second after the run, and closes the file after that. Sleeps
// 50 ms and returns true; returns false after 10 s.
[[nodiscard]] bool wait_for_service(int tries);

// Each appends one signature to the closed run file `path` and returns it as written, for the ledger. The caller fills
// in name, meaning, reason and utc; seq and head become those of the last entry. Waits for the disk. Fails if the run
// has not ended or its chain is broken; then the file is as before.
//
// The service countersigns for `person`, which the caller fills in. `service` must be the key that signed the run.
[[nodiscard]] Result<PersonalSignature> sign_by_service(const std::string& path, PersonalSignature signature,
                                                        const SigningKey& service,
                                                        const WhileBusy& busy = wait_for_service);
// Signs with the person's own key; needs no service.
[[nodiscard]] Result<PersonalSignature> sign_by_own_key(const std::string& path, PersonalSignature signature,
                                                        const SigningKey& own,
                                                        const WhileBusy& busy = wait_for_service);

}  // namespace dwell::record
