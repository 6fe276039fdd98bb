#include "tests/daemon/failing_new.hpp"

#include <cstdlib>
#include <new>

namespace {
thread_local int allocations_left = -1;
}  // namespace

namespace dwell::test {
void fail_allocation(int left) noexcept { allocations_left = left; }
}  // namespace dwell::test

// ThreadSanitizer brings operators of its own, which cannot be replaced; nothing fails under it.
#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define DWELL_NOTHING_FAILS
#endif
#endif
#ifndef DWELL_NOTHING_FAILS
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  const bool may_allocate = allocations_left < 0 || allocations_left-- != 0;
  return may_allocate ? std::malloc(size == 0 ? 1 : size) : nullptr;
}
void* operator new(std::size_t size) {
  if (void* const memory = operator new(size, std::nothrow)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory, const std::nothrow_t&) noexcept { std::free(memory); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif
