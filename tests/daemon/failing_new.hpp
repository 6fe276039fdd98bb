// Memory that ends: where failing_new.cpp is linked in, operator new throws when told to.
#pragma once

namespace dwell::test {

// On this thread `left` more allocations succeed and the one after them fails, once; negative: none fails.
void fail_allocation(int left) noexcept;

}  // namespace dwell::test
