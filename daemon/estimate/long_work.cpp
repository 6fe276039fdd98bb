#include "daemon/estimate/long_work.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <exception>
#include <string>
#include <utility>

namespace dwell {
namespace {

// Beside a thread of usual priority it gets a tenth of a processor; alone, all of it. 0: an estimate slows what a
// polling loop or a web page does; 19: on a busy computer estimates come too late to be of use.
constexpr int kNice = 10;

void give_up(TransientJob& job, const std::string& why) {
  job.result.estimate = {};
  job.result.estimate.reason = "the estimate failed: " + why;
}
void give_up(VerificationJob& job, const std::string& why) {
  job.result.verification = {};
  job.result.verification.reasons = {"the verification failed: " + why};
}

template <class Job, class Run>
bool work_on(WorkSlot<Job>& slot, const Run& run) {
  return slot.work([&run](Job& job) {
    try {
      run(job);
    } catch (const std::exception& failure) {
      give_up(job, failure.what());
    }
  });
}

}  // namespace

bool LongWork::estimate() {
  return work_on(estimates, [this](TransientJob& job) { job.run(rig); });
}

bool LongWork::verify() {
  return work_on(verifications, [this](VerificationJob& job) { job.run(rig, accuracy); });
}

LongWorkThread::LongWorkThread(std::shared_ptr<LongWork> work, Does does)
    : shared_(std::make_shared<Shared>(std::move(work), does)), thread_([shared = shared_] { run(shared); }) {}

LongWorkThread::~LongWorkThread() {
  shared_->stop.store(true);
  if (shared_->does == Does::estimates)
    shared_->work->estimates.ring();
  else
    shared_->work->verifications.ring();
  // Either `busy` is seen here, or the thread sees `stop` before it begins a job: both are sequentially consistent. So
  // join() never waits for a job that begins after stop.
  if (shared_->busy.load()) {
    thread_.detach();
  } else {
    thread_.join();
  }
}

void LongWorkThread::run(const std::shared_ptr<Shared>& shared) {
  LongWork& work = *shared->work;
  const bool estimates = shared->does == Does::estimates;
  pthread_setname_np(pthread_self(), estimates ? "motion" : "verify");
  // Of this thread alone, as Linux has it. Where it is refused, the work is done at the usual priority.
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  if (estimates)
    serve(work.estimates, &LongWork::estimate, *shared);
  else
    serve(work.verifications, &LongWork::verify, *shared);
}

template <class Job>
void LongWorkThread::serve(WorkSlot<Job>& slot, bool (LongWork::*work)(), Shared& shared) {
  while (!shared.stop.load()) {
    slot.wait();
    shared.busy.store(true);
    if (!shared.stop.load()) (shared.work.get()->*work)();
    shared.busy.store(false);
  }
}

}  // namespace dwell
