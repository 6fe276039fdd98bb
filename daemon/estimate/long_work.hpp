// The threads for what takes seconds: one for coefficients from a transient, one for the verification of a model. Each
// does one job at a time, at nice 10, below all threads that measure; nobody waits for them. There are two, so that the
// verification of a model does not wait for an estimate, which may take minutes where it looks for what is missing.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include "core/motion/transient_watch.hpp"
#include "core/rig/rig.hpp"
#include "core/verify/verification_watch.hpp"
#include "daemon/estimate/work_slot.hpp"

namespace dwell {

// What the estimation thread and the workers hold: the slots between them, and what a job needs, which nobody changes.
struct LongWork {
  LongWork(Rig the_rig, double the_accuracy) : rig(std::move(the_rig)), accuracy(the_accuracy) {}

  // The worker of a slot, or a test: does the job that waits there; false: none does. Throws nothing: a failure is
  // stored as the job's reason.
  bool estimate();
  bool verify();

  const Rig rig;
  const double accuracy;  // asked for of predictions, of each channel's rms
  WorkSlot<TransientJob> estimates;
  WorkSlot<VerificationJob> verifications;
};

class LongWorkThread {
 public:
  enum class Does : std::uint8_t { estimates, verifications };
  // Starts at once.
  LongWorkThread(std::shared_ptr<LongWork> work, Does does);
  // Does not wait: a running job may take seconds to notice that it is unwanted, and must not hold up the end of the
  // run. Its thread is then detached, keeps its data alive, and ends with the job.
  ~LongWorkThread();
  LongWorkThread(const LongWorkThread&) = delete;
  LongWorkThread& operator=(const LongWorkThread&) = delete;

 private:
  struct Shared {
    Shared(std::shared_ptr<LongWork> the_work, Does what) : work(std::move(the_work)), does(what) {}
    const std::shared_ptr<LongWork> work;
    const Does does;
    std::atomic<bool> stop{false};  // written by the owner
    std::atomic<bool> busy{false};  // written by the thread
  };
  static void run(const std::shared_ptr<Shared>& shared);
  template <class Job>
  static void serve(WorkSlot<Job>& slot, bool (LongWork::*work)(), Shared& shared);

  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace dwell
