// The argument --key of the verbs that check signatures.
#pragma once

#include <string>

#include "daemon/record/keys.hpp"

namespace dwell::ctl {

// asked: a vkey, or a file whose first line is a vkey. Fails with what is wrong.
[[nodiscard]] record::Result<record::PublicKey> pinned_key(const std::string& asked);

}  // namespace dwell::ctl
