/* Plugins built as if against another header of the same interface version. OLDER: its table ends before the last
 * member, and what lies behind it is poison. NEWER: its table and its keys have members of which the host knows
 * nothing, and it offers to use a member of the host's that is not there. Each delivers one sample, 42, as it starts.
 */
#include <stddef.h>
#include <stdlib.h>

#include "drivers/dwell_driver.h"

static void poison(void) { abort(); }

#ifdef NEWER
struct key {
  dwell_key known;
  double later;
  void (*later_still)(void);
};
struct host {
  dwell_host known;
  void (*later)(void* context);
};
struct table {
  dwell_driver_table known;
  void (*later)(void);
};
#define NAME "newer"
#define TABLE_SIZE sizeof(struct table)
#define KEY(name, minimum, maximum) \
  { {name, DWELL_DEVICE, DWELL_REAL, 0, minimum, maximum, NULL, "Hz", "help of " name}, 1e300, poison }
#else
struct key {
  dwell_key known;
};
struct table {
  dwell_driver_table known;
};
#define NAME "older"
#define TABLE_SIZE offsetof(dwell_driver_table, describe)
#define KEY(name, minimum, maximum)                                                      \
  {                                                                                      \
    { name, DWELL_DEVICE, DWELL_REAL, 0, minimum, maximum, NULL, "Hz", "help of " name } \
  }
#endif

static const struct key keys[] = {KEY("first", 1, 2), KEY("second", 3, 4), KEY("third", 5, 6)};

struct instance {
  dwell_host host;
  uint16_t channel;
};

static void check(const dwell_settings* s, dwell_report report, void* context) { (void)s, (void)report, (void)context; }
static void probe(const dwell_settings* s, dwell_probed probed, void* context) { (void)s, (void)probed, (void)context; }
static void* create(const dwell_settings* s, const dwell_host* host, char* error, size_t size) {
  struct instance* made = malloc(sizeof *made);
  (void)error, (void)size;
#ifdef NEWER
  if (host->size >= sizeof(struct host)) ((const struct host*)host)->later(host->context);
#endif
  made->host = *host;
  made->channel = s->channels[0].index;
  return made;
}
static int32_t start(void* instance, char* error, size_t size) {
  const struct instance* const me = instance;
  const dwell_sample sample = {1000, 42.0, 1, me->channel, 0};
  (void)error, (void)size;
  me->host.state(me->host.context, -1, DWELL_FAULT_NONE, NULL);
  me->host.count(me->host.context, DWELL_FAULT_TIMEOUT, 7);
  return me->host.push(me->host.context, &sample, 1) == 1 ? 0 : 1;
}
static void stop(void* instance) { (void)instance; }

#ifdef NEWER
static void describe(const dwell_settings* s, dwell_traits* traits) {
  (void)s;
  traits->age_ns = 77;
}
#define TAIL \
  describe   \
  }          \
  , poison
#else
#define TAIL                                              \
  (void (*)(const dwell_settings*, dwell_traits*)) poison \
  }
#endif

static const struct table table = {{TABLE_SIZE, DWELL_DRIVER_ABI, NAME, "0", "", &keys[0].known, 3, sizeof(struct key),
                                    check, probe, create, start, stop, free, TAIL};

__attribute__((visibility("default"))) const dwell_driver_table* dwell_driver(void) { return &table.known; }
