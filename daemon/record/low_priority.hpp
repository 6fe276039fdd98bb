// For threads whose work may wait: they leave processor and disk to whoever else wants them.
#pragma once

namespace dwell::record {

// Gives the calling thread the lowest priority of ordinary threads, and its disk accesses the lowest as well. Where the
// system refuses, the thread goes on as it was.
void lower_priority() noexcept;

}  // namespace dwell::record
