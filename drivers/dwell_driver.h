/* The driver plugin interface of Dwell, version 1.
 *
 * A driver is a shared object `dwell-driver-NAME.so` that exports one function, dwell_driver(). It returns a table of
 * plain C functions. The host (dwelld, dwellctl) validates the rig file against the plugin's own key schema, creates
 * one instance per [[device]], starts it, and takes what it pushes. No C++ type, no exception and no ownership crosses
 * this interface; plugins are never unloaded.
 *
 * Plugin and host may be built against headers of different age. Later headers of this version add members at the end
 * of the structs that begin with `size`, their own size in bytes, and at the end of dwell_key, whose size the table
 * states. A reader takes no more than the writer's size covers; members beyond count as zero: NULL, not known. The host
 * walks the keys by the table's `key_size`. All other structs stay as they are.
 *
 * Unless said otherwise a function is called from one thread at a time per instance and need not be real-time safe.
 * Strings are UTF-8, zero-terminated, owned by whoever hands them in, valid for the call only; those in the table are
 * valid for ever. Instants are ns of CLOCK_MONOTONIC_RAW.
 */
#ifndef DWELL_DRIVER_H
#define DWELL_DRIVER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define DWELL_DRIVER_ABI 1u

/* One reading. `raw` is the device's own number, before the rig file's scale and offset. */
typedef struct dwell_sample {
  int64_t t_ns;       /* instant of the reading */
  double raw;         /* finite; what is not must not be pushed but reported as DWELL_FAULT_INVALID_VALUE */
  uint32_t t_half_ns; /* the true instant lies within t_ns ± this, evenly likely */
  uint16_t channel;   /* the dwell_channel's index */
  uint16_t flags;     /* DWELL_SAMPLE_... */
} dwell_sample;

#define DWELL_SAMPLE_GAP 1u            /* samples of this channel were lost immediately before */
#define DWELL_SAMPLE_STAMP_REPLACED 2u /* the device's own stamp was implausible and was replaced */

/* Faults, counted by kind; the numbers are recorded and never change. */
typedef enum dwell_fault {
  DWELL_FAULT_NONE = 0,
  DWELL_FAULT_DISCONNECTED = 1,
  DWELL_FAULT_TIMEOUT = 2,
  DWELL_FAULT_EXCEPTION = 3,
  DWELL_FAULT_BAD_CHECKSUM = 4,
  DWELL_FAULT_SHORT_FRAME = 5,
  DWELL_FAULT_BAD_FRAME = 6,
  DWELL_FAULT_LATE_ANSWER = 7,
  DWELL_FAULT_INVALID_VALUE = 8,
  DWELL_FAULT_MISSED_DEADLINE = 9,
  DWELL_FAULT_END_OF_DATA = 10,
  DWELL_FAULT_SILENT = 11,
  DWELL_FAULT_OVERFLOW = 12,  /* lost for lack of room: on the way in (kernel, controller), or waiting to be sent */
  DWELL_FAULT_BUS_ERROR = 13, /* the bus controller reports errors on the line */
  DWELL_FAULT_BUS_OFF = 14,   /* the bus controller has left the bus for too many of them */
  DWELL_FAULT_UNTIMELY = 15, /* said by the host: readings come too late to be put in order, or stamped ahead of time */

  DWELL_FAULT_RESERVED = 255 /* what lies between is for later versions */
} dwell_fault;

typedef enum dwell_type { DWELL_BOOLEAN = 0, DWELL_INTEGER = 1, DWELL_REAL = 2, DWELL_STRING = 3 } dwell_type;
typedef enum dwell_scope { DWELL_DEVICE = 0, DWELL_CHANNEL = 1 } dwell_scope;

/* One key that the plugin understands in [[device]] or [[channel]]. An integer in the file satisfies DWELL_REAL. May
 * grow: only dwell_driver_table::key_size says where the next key begins. */
typedef struct dwell_key {
  const char* name;
  dwell_scope scope;
  dwell_type type;
  int32_t required; /* 1: the file must give it */
  double minimum;   /* numbers: inclusive bounds; minimum > maximum: unbounded */
  double maximum;
  const char* choices; /* strings: "tcp|rtu", or NULL: any */
  const char* unit;    /* "s", "Hz", or "" */
  const char* help;    /* one line for the manual */
} dwell_key;

/* One key as given in the file; a key that was not given is absent. */
typedef struct dwell_entry {
  const char* key;
  dwell_type type;
  int32_t boolean;
  int64_t integer;
  double real;        /* set for DWELL_INTEGER as well */
  const char* string; /* NULL unless DWELL_STRING */
} dwell_entry;

typedef struct dwell_channel {
  const char* name;
  uint16_t index; /* what dwell_sample::channel must carry */
  const dwell_entry* entries;
  size_t entry_count;
} dwell_channel;

/* Everything an instance is made from; validated against the key schema. Its entries and channels do not grow. */
typedef struct dwell_settings {
  uint32_t size;
  const char* device;
  const char* directory; /* of the rig file: relative paths in its values start there */
  const dwell_entry* entries;
  size_t entry_count;
  const dwell_channel* channels;
  size_t channel_count;
} dwell_settings;

typedef enum dwell_level { DWELL_DEBUG = 0, DWELL_INFO = 1, DWELL_WARNING = 2, DWELL_ERROR = 3 } dwell_level;

/* What the host offers. All of it may be called from the instance's own thread between start and the return of stop. */
typedef struct dwell_host {
  uint32_t size;
  void* context; /* first argument of every call */

  /* Hands in one scan: readings that belong together, entered whole or refused whole. 1 accepted, 0 refused (no room;
   * the host counts, and marks the gap on the next accepted scan). Real-time safe: no lock, no allocation, no system
   * call. */
  int32_t (*push)(void* context, const dwell_sample* samples, size_t count);

  /* The channel (its index; -1: every channel of the device) does not deliver, and why; DWELL_FAULT_NONE: it does
   * again. Say it when it changes; saying it again is harmless. `reason` is one line for people, or NULL. */
  void (*state)(void* context, int32_t channel, dwell_fault fault, const char* reason);

  /* So many occurrences of a fault, counted by the host; they need not have made a channel stale. Real-time safe. */
  void (*count)(void* context, dwell_fault fault, uint64_t occurrences);

  /* One line of log. Never from the path of a sample that arrived well. */
  void (*log)(void* context, dwell_level level, const char* message);

  /* The instance's thread is alive: call once per turn of its loop, retries and waits included, at least every 0.5 s.
   */
  void (*turn)(void* context);

  /* How many samples the next push is sure to find room for. For a source that can wait instead of losing a scan: push
   * only what fits, as a refused scan is a loss. Real-time safe, like push. NULL: the host does not tell. */
  size_t (*room)(void* context);
} dwell_host;

/* Receives one mistake of check: `channel` an index into settings->channels or -1 for the device, `key` the offending
 * key or NULL, `message` what is wrong and what was expected. */
typedef void (*dwell_report)(void* context, int32_t channel, const char* key, const char* message);

/* Receives one result of probe: `channel` an index into settings->channels; error NULL: raw was read, and took
 * latency_ns from request to answer. */
typedef void (*dwell_probed)(void* context, size_t channel, double raw, int64_t latency_ns, const char* error);

/* No bound for dwell_traits::age_ns: samples grow ever older. */
#define DWELL_AGE_UNBOUNDED INT64_MAX

/* What an instance of these settings would do, as far as the driver knows it without the device. 0: not known. The host
 * sets `size` and zeroes the rest; a driver fills in what lies within `size`. */
typedef struct dwell_traits {
  uint32_t size;
  int32_t rate_may_shift; /* 1: the host may set the key `rate` to up to 1 % beside what the file says, so that
                           * harmonics of the drive do not read as others */
  double rate_hz;         /* readings of a channel per second, defaults applied */
  int64_t age_ns; /* how long after its stamp a sample may be pushed at most, the computer's own delays apart. Every
                   * driver states it: the host waits that long for the device (10 s at most) before it puts the
                   * stream in order, and what comes still later is lost. 0: not stated; the host waits 0.1 s */
  int32_t leads; /* 1: stamps may run ahead of the clock, as those of a recording played faster than time; of all others
                  * a stamp in the future is a mistake, and its sample is dropped */
  double most_rate_hz; /* readings of a channel per second that the line can carry at most */
  int32_t recorded;    /* 1: it plays a recording in place of a rig: operators are told that its readings are old */
} dwell_traits;

typedef struct dwell_driver_table {
  uint32_t size;    /* sizeof(dwell_driver_table) of the plugin's header */
  uint32_t abi;     /* DWELL_DRIVER_ABI */
  const char* name; /* as in the rig file's `driver` */
  const char* version;
  const char* help; /* one line */
  const dwell_key* keys;
  size_t key_count;
  size_t key_size; /* sizeof(dwell_key) of the plugin's header: from one key to the next */

  /* What the schema cannot say (a key needed only with another, two channels that collide): reports every mistake. */
  void (*check)(const dwell_settings* settings, dwell_report report, void* context);

  /* Reads every channel once, without an instance; blocks at most about a second per device that does not answer. */
  void (*probe)(const dwell_settings* settings, dwell_probed probed, void* context);

  /* Makes an instance; settings and host are copied as needed, host->context stays valid until destroy. NULL: failed,
   * with one line in error (error_size bytes). Does not touch the device: a rig that is off is not a failure. */
  void* (*create)(const dwell_settings* settings, const dwell_host* host, char* error, size_t error_size);

  /* Begins to deliver, from a thread of its own. 0 done, else failed with one line in error. */
  int32_t (*start)(void* instance, char* error, size_t error_size);

  /* Ends delivering; returns within 0.5 s, after which no callback is made. May be called without start. */
  void (*stop)(void* instance);

  void (*destroy)(void* instance);

  /* What is known of the device by its settings, which may still have mistakes that check would find; does not touch
   * the device. NULL, or a table that ends before: nothing. */
  void (*describe)(const dwell_settings* settings, dwell_traits* traits);
} dwell_driver_table;

/* The one exported symbol. */
const dwell_driver_table* dwell_driver(void);
typedef const dwell_driver_table* (*dwell_driver_function)(void);
#define DWELL_DRIVER_SYMBOL "dwell_driver"

#ifdef __cplusplus
}
#endif

#endif
