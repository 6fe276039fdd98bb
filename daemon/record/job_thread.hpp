// A thread that does one thing after the other for a thread that must not wait for it.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

namespace dwell::record {

// A job may hang in what it waits for, another computer's disk for instance. Then the thread is left behind: jobs own
// what they use.
class JobThread {
 public:
  // Jobs that wait at most.
  static constexpr std::size_t kJobs = 256;
  // The end waits so long for a job that is being done.
  static constexpr std::chrono::seconds kPatience{1};

  explicit JobThread(std::string name);
  // What waits behind the job that is being done is not done.
  ~JobThread();
  JobThread(const JobThread&) = delete;
  JobThread& operator=(const JobThread&) = delete;

  // Asked by long jobs: whether the thread is to end. May be called as long as the job runs. Thread-safe.
  using Stopping = std::function<bool()>;
  // false: too many wait. A job must not throw. Thread-safe.
  bool post(std::function<void(const Stopping&)> job);

 private:
  struct Shared;
  static void run(const std::shared_ptr<Shared>& shared, const std::string& name);

  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace dwell::record
