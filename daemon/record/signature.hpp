// A person's signature at the end of a closed run file. Either the service vouches for who signs, by its note, or the
// person signs with a key of their own. docs/run-file.md, "Signatures".
#pragma once

#include <string>

#include "daemon/record/run_entries.hpp"

namespace dwell::record {

// The lines that a key of a person's own signs, each with its newline. Fails where a member holds a control character,
// a newline for instance.
[[nodiscard]] Result<std::string> signature_text(const std::string& run_id, const PersonalSignature& signature);

// Each appends one signature to the closed run file `path` and returns it as written, for the ledger. The caller fills
// name, meaning, reason and utc; seq and head are of the last entry there is. Waits for the disk. Fails, with the file
// as it was, where the run has not ended or its chain does not hold.
//
// Countersigned by the service, for the `person` filled in. `service` must be the key that signed the run.
[[nodiscard]] Result<PersonalSignature> sign_by_service(const std::string& path, PersonalSignature signature,
                                                        const SigningKey& service);
// With a key of the person's own; needs no service.
[[nodiscard]] Result<PersonalSignature> sign_by_own_key(const std::string& path, PersonalSignature signature,
                                                        const SigningKey& own);

}  // namespace dwell::record
