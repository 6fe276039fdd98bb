// The arguments --key and --person of the verbs that check signatures.
#pragma once

#include <string>
#include <vector>

#include "daemon/record/keys.hpp"

namespace dwell::ctl {

// Each of `asked`: a vkey, or a file with vkeys, one a line; blank lines and those that begin with # are skipped. Fails
// with what is wrong.
[[nodiscard]] record::Result<std::vector<record::PublicKey>> pinned_keys(const std::vector<std::string>& asked);

}  // namespace dwell::ctl
