#include "daemon/record/low_priority.hpp"

#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace dwell::record {
namespace {

constexpr int kNicest = 19;
// ioprio_set(2); glibc has no header for it. Idle: the disk is asked only while nobody else asks it.
constexpr int kThisThread = 1, kIdleClass = 3 << 13;

}  // namespace

void lower_priority() noexcept {
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNicest);
  (void)syscall(SYS_ioprio_set, kThisThread, 0, kIdleClass);
}

}  // namespace dwell::record
