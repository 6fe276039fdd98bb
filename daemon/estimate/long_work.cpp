#include "daemon/estimate/long_work.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <exception>
#include <string>
#include <type_traits>
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

}  // namespace

bool LongWork::work() {
  const auto run = [this](auto& job) {
    if constexpr (std::is_same_v<std::decay_t<decltype(job)>, TransientJob>) {
      job.run(rig);
    } else {
      job.run(rig, accuracy);
    }
  };
  return slot.work([&](LongJob& job) {
    try {
      std::visit(run, job);
    } catch (const std::exception& failure) {
      std::visit([&](auto& failed) { give_up(failed, failure.what()); }, job);
    }
  });
}

LongWorkThread::LongWorkThread(std::shared_ptr<LongWork> work)
    : shared_(std::make_shared<Shared>(std::move(work))), thread_([shared = shared_] { run(shared); }) {}

LongWorkThread::~LongWorkThread() {
  shared_->stop.store(true);
  shared_->work->slot.ring();
  // Either `busy` is seen here, or the thread sees `stop` before it begins a job: both are sequentially consistent. So
  // join() never waits for a job that begins after stop.
  if (shared_->busy.load()) {
    thread_.detach();
  } else {
    thread_.join();
  }
}

void LongWorkThread::run(const std::shared_ptr<Shared>& shared) {
  pthread_setname_np(pthread_self(), "motion");
  // Of this thread alone, as Linux has it. Where it is refused, the work is done at the usual priority.
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  while (!shared->stop.load()) {
    shared->work->slot.wait();
    shared->busy.store(true);
    if (!shared->stop.load()) shared->work->work();
    shared->busy.store(false);
  }
}

}  // namespace dwell
