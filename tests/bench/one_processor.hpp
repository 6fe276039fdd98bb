// For figures of two threads that take turns: free to wander, the same loop costs three times as much in one run as in
// the next.
#pragma once

#include <sched.h>

namespace dwell::bench {

// Keeps this thread, and what it starts, to the first processor it may use, for as long as this object lives.
class OneProcessor {
 public:
  OneProcessor() {
    ::sched_getaffinity(0, sizeof allowed_, &allowed_);
    int first = 0;
    while (first < CPU_SETSIZE - 1 && !CPU_ISSET(first, &allowed_)) ++first;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(first, &one);
    ::sched_setaffinity(0, sizeof one, &one);
  }
  ~OneProcessor() { ::sched_setaffinity(0, sizeof allowed_, &allowed_); }
  OneProcessor(const OneProcessor&) = delete;
  OneProcessor& operator=(const OneProcessor&) = delete;

 private:
  cpu_set_t allowed_{};
};

}  // namespace dwell::bench
