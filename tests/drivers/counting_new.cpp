// Counts allocations per thread for the whole program, plugins included, since they find this operator before the
// library's.
#include <cstdlib>
#include <new>

#include "tests/drivers/fake_host.hpp"

namespace {
thread_local std::size_t allocations = 0;
}

namespace dwell::test {
std::size_t allocations_of_this_thread() noexcept { return allocations; }
}  // namespace dwell::test

void* operator new(std::size_t size) {
  ++allocations;
  if (void* const memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
