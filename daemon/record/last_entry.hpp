// The last entry of a chained file, found in a few reads however long the file is.
#pragma once

#include "daemon/record/chain_file.hpp"

namespace dwell::record {

// Fails with the reason, and where the file has no entry. Leaves the reader anywhere.
[[nodiscard]] Result<ChainReader::Row> last_entry(ChainReader& reader);

}  // namespace dwell::record
