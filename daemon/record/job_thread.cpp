#include "daemon/record/job_thread.hpp"

#include <pthread.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <utility>

namespace dwell::record {

struct JobThread::Shared {
  std::mutex mutex;
  std::condition_variable wake, idle, ended;
  std::deque<std::function<void(const Stopping&)>> jobs;
  bool stop = false, busy = false, done = false;
};

JobThread::JobThread(std::string name)
    : shared_(std::make_shared<Shared>()), thread_([shared = shared_, name = std::move(name)] { run(shared, name); }) {}

JobThread::~JobThread() {
  std::unique_lock lock(shared_->mutex);
  shared_->stop = true;
  shared_->wake.notify_all();
  const bool done = shared_->ended.wait_for(lock, kPatience, [this] { return shared_->done; });
  lock.unlock();
  if (done) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

bool JobThread::post(std::function<void(const Stopping&)> job) {
  {
    const std::lock_guard lock(shared_->mutex);
    if (shared_->jobs.size() == kJobs) return false;
    shared_->jobs.push_back(std::move(job));
  }
  shared_->wake.notify_one();
  return true;
}

bool JobThread::settle(std::chrono::milliseconds limit) const {
  std::unique_lock lock(shared_->mutex);
  return shared_->idle.wait_for(lock, limit, [this] { return shared_->jobs.empty() && !shared_->busy; });
}

bool JobThread::full() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->jobs.size() == kJobs;
}

void JobThread::run(const std::shared_ptr<Shared>& shared, const std::string& name) {
  pthread_setname_np(pthread_self(), name.c_str());
  const Stopping stopping = [shared] {
    const std::lock_guard lock(shared->mutex);
    return shared->stop;
  };
  std::unique_lock lock(shared->mutex);
  for (;;) {
    shared->wake.wait(lock, [&] { return shared->stop || !shared->jobs.empty(); });
    if (shared->stop) break;
    auto job = std::move(shared->jobs.front());
    shared->jobs.pop_front();
    shared->busy = true;
    lock.unlock();
    job(stopping);
    job = nullptr;  // what it owned goes without the lock: closing a file may take long
    lock.lock();
    shared->busy = false;
    if (shared->jobs.empty()) shared->idle.notify_all();
  }
  shared->done = true;
  shared->ended.notify_all();
}

}  // namespace dwell::record
