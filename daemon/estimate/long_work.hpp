// The thread for what takes seconds: coefficients from a transient, the verification of a model. One at a time, and
// behind all others: it runs at a lower priority and may fall behind; nobody waits for it.
#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <variant>

#include "core/motion/transient_watch.hpp"
#include "core/motion/verification_watch.hpp"
#include "core/rig/rig.hpp"
#include "daemon/estimate/work_slot.hpp"

namespace dwell {

using LongJob = std::variant<TransientJob, VerificationJob>;

// What both threads hold: the slot between them, and what a job needs, which nobody changes.
struct LongWork {
  LongWork(Rig the_rig, double the_accuracy) : rig(std::move(the_rig)), accuracy(the_accuracy) {}

  // Worker, or a test: does the job that waits; false: none does. Throws nothing: what fails is the job's reason.
  bool work();

  const Rig rig;
  const double accuracy;  // asked for of predictions, of each channel's rms
  WorkSlot<LongJob> slot;
};

class LongWorkThread {
 public:
  // Starts at once.
  explicit LongWorkThread(std::shared_ptr<LongWork> work);
  // Takes no time: a job that is being done cannot be interrupted, and must not cost the end of the run. Its thread is
  // left to itself then, with all it needs, and goes when the job is done.
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
