#pragma once

// GCC defines a macro for each sanitizer, Clang has a feature.
#ifdef __has_feature
#define DWELL_HAS_FEATURE(name) __has_feature(name)
#else
#define DWELL_HAS_FEATURE(name) 0
#endif

namespace dwell {

// True where the tests are built with AddressSanitizer. What it looks for are errors of memory, for which a few draws
// of a population do; each takes seconds there.
#if defined(__SANITIZE_ADDRESS__) || DWELL_HAS_FEATURE(address_sanitizer)
inline constexpr bool kUnderSanitizer = true;
#else
inline constexpr bool kUnderSanitizer = false;
#endif

// True where the tests are built with ThreadSanitizer, which makes them some ten times slower.
#if defined(__SANITIZE_THREAD__) || DWELL_HAS_FEATURE(thread_sanitizer)
inline constexpr bool kUnderThreadSanitizer = true;
#else
inline constexpr bool kUnderThreadSanitizer = false;
#endif

// How many draws of a population a test plays: `all`, or `few` under AddressSanitizer.
constexpr int draws(int all, int few) { return kUnderSanitizer ? few : all; }

}  // namespace dwell

#undef DWELL_HAS_FEATURE
