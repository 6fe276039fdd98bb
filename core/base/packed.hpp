// Two numbers in one register of the baseline instruction set (GCC's and Clang's vector extension).
//
// Most loops over doubles are vectorized without it. It is for the places where the compiler does not, or where two
// numbers that are soon read together must be stored together: a processor that reads 16 bytes just after two stores of
// 8 bytes waits until both stores are in its cache, as long as twenty multiplications.
#pragma once

#include <cstring>

namespace dwell {

template <class Number>
using Packed [[gnu::vector_size(16)]] = Number;

// Stores both at once, at[0] and at[1]. Real-time safe.
inline void store_two(double* at, double first, double second) noexcept {
  const Packed<double> both{first, second};
  std::memcpy(at, &both, sizeof both);
}

}  // namespace dwell
