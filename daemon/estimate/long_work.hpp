// The thread for what takes seconds: coefficients from a transient, the verification of a model. It does one job at a
// time, at a lower priority than all other threads; nobody waits for it.
#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <variant>

#include "core/motion/transient_watch.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/verification_watch.hpp"
#include "daemon/estimate/work_slot.hpp"

namespace dwell {

using LongJob = std::variant<TransientJob, VerificationJob>;

// What both threads hold: the slot between them, and what a job needs, which nobody changes.
struct LongWork {
  LongWork(Rig the_rig, double the_accuracy) : rig(std::move(the_rig)), accuracy(the_accuracy) {}

  // Worker, or a test: does the job that waits; false: none does. Throws nothing: a failure is
  // stored as the job's reason.
  bool work();

  const Rig rig;
  const double accuracy;  // asked for of predictions, of each channel's rms
  WorkSlot<LongJob> slot;
};

class LongWorkThread {
 public:
  // Starts at once.
  explicit LongWorkThread(std::shared_ptr<LongWork> work);
  // Does not wait: a running job cannot be interrupted and must not hold up the end of the run. Its thread is then
  // detached, keeps its data alive, and ends with the job.
  ~LongWorkThread();
  LongWorkThread(const LongWorkThread&) = delete;
  LongWorkThread& operator=(const LongWorkThread&) = delete;

 private:
  struct Shared {
    explicit Shared(std::shared_ptr<LongWork> the_work) : work(std::move(the_work)) {}
    const std::shared_ptr<LongWork> work;
    std::atomic<bool> stop{false};  // written by the owner
    std::atomic<bool> busy{false};  // written by the thread
  };
  static void run(const std::shared_ptr<Shared>& shared);

  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace dwell
