// Moves the wall clock of the guest: clock-set step SECONDS | clock-set slew PPM.
// Or says how well it is known, as a time daemon would: clock-set synchronized ERROR_US; below 0: not.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/timex.h>
#include <time.h>

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const double amount = atof(argv[2]);
  if (strcmp(argv[1], "step") == 0) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    now.tv_sec += (time_t)amount;
    if (clock_settime(CLOCK_REALTIME, &now) != 0) return perror("clock_settime"), 1;
    return 0;
  }
  if (strcmp(argv[1], "synchronized") == 0) {
    struct timex known = {.modes = ADJ_STATUS | ADJ_MAXERROR | ADJ_ESTERROR};
    known.status = amount < 0.0 ? STA_UNSYNC : STA_PLL;
    known.maxerror = known.esterror = amount < 0.0 ? 16000000 : (long)amount;
    if (adjtimex(&known) < 0) return perror("adjtimex"), 1;
    return 0;
  }
  // The rate that adjtimex takes as a frequency, in units of 2^-16 ppm, is what NTP would set.
  struct timex change = {.modes = ADJ_FREQUENCY, .freq = (long)(amount * 65536.0)};
  if (adjtimex(&change) < 0) return perror("adjtimex"), 1;
  return 0;
}
