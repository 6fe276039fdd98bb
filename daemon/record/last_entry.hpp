// Finds the last entry of a chained file in a few reads, however long the file is.
#pragma once

#include "daemon/record/chain_file.hpp"

namespace dwell::record {

// Fails with the reason, also if the file has no entry. The reader's place is undefined afterwards.
[[nodiscard]] Result<ChainReader::Row> last_entry(ChainReader& reader);

}  // namespace dwell::record
