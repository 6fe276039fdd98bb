// Prints the rate of this machine's time-stamp counter in kHz. The emulated processor has the same one; told its rate,
// the guest need not measure it against an emulated timer, which fails, and hangs the guest, where this machine is
// busy.
#include <stdio.h>
#include <time.h>
#include <x86intrin.h>

static double now_ms(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC_RAW, &now);
  return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

int main(void) {
  const double began_ms = now_ms();
  const unsigned long long began = __rdtsc();
  double ended_ms = began_ms;
  while (ended_ms - began_ms < 200.0) ended_ms = now_ms();
  printf("%.0f\n", (double)(__rdtsc() - began) / (ended_ms - began_ms));
  return 0;
}
