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

// ThreadSanitizer brings operators of its own, which cannot be replaced; nothing is counted under it.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define DWELL_COUNTS_NOTHING
#endif
#endif
#ifndef DWELL_COUNTS_NOTHING
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++allocations;
  return std::malloc(size == 0 ? 1 : size);
}
void* operator new(std::size_t size) {
  if (void* const memory = operator new(size, std::nothrow)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif
