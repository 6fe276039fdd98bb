/* Plugins that are wrong in one way each: BAD_ABI, BAD_SIZE, BAD_STOP, BAD_TABLE, BAD_SYMBOL, BAD_KEY_SIZE. */
#include "drivers/dwell_driver.h"

static void check(const dwell_settings* s, dwell_report report, void* context) { (void)s, (void)report, (void)context; }
static void probe(const dwell_settings* s, dwell_probed probed, void* context) { (void)s, (void)probed, (void)context; }
static void* create(const dwell_settings* s, const dwell_host* host, char* error, size_t size) {
  (void)s, (void)host, (void)error, (void)size;
  return NULL;
}
static int32_t start(void* instance, char* error, size_t size) {
  (void)instance, (void)error, (void)size;
  return 1;
}
static void done(void* instance) { (void)instance; }

#ifndef BAD_ABI
#define BAD_ABI DWELL_DRIVER_ABI
#endif
#ifndef BAD_SIZE
#define BAD_SIZE sizeof(dwell_driver_table)
#endif
#ifndef BAD_KEY_SIZE
#define BAD_KEY_SIZE sizeof(dwell_key)
#endif
#ifndef BAD_STOP
#define BAD_STOP done
#endif
#ifndef BAD_SYMBOL
#define BAD_SYMBOL dwell_driver
#endif

static const dwell_key key = {"rate", DWELL_DEVICE, DWELL_REAL, 0, 1, 0, NULL, "Hz", ""};
static const dwell_driver_table table = {BAD_SIZE,     BAD_ABI, BAD_NAME, "0",    "",    &key,     1,
                                         BAD_KEY_SIZE, check,   probe,    create, start, BAD_STOP, done};

__attribute__((visibility("default"))) const dwell_driver_table* BAD_SYMBOL(void) {
#ifdef BAD_TABLE
  (void)table;
  return NULL;
#else
  return &table;
#endif
}
