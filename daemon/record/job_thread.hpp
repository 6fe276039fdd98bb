// Does jobs one after the other, for a thread that must not wait for them.
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

namespace dwell::record {

// A job may hang, for instance on another computer's disk. Then its thread is left behind, so a job must own what it
// uses.
class JobThread {
 public:
  // Most jobs that wait.
  static constexpr std::size_t kJobs = 256;
  // The destructor waits so long for the current job.
  static constexpr std::chrono::seconds kPatience{1};

  explicit JobThread(std::string name);
  // Drops the jobs that wait behind the current one.
  ~JobThread();
  JobThread(const JobThread&) = delete;
  JobThread& operator=(const JobThread&) = delete;

  // Whether the thread is to end. Long jobs ask it while they run. Thread-safe.
  using Stopping = std::function<bool()>;
  // false: too many wait. A job must not throw. Thread-safe.
  bool post(std::function<void(const Stopping&)> job);
  // Waits until all posted jobs are done, so long at most. false: they are not. Thread-safe.
  bool settle(std::chrono::milliseconds limit) const;
  // Whether post() would refuse a job. Where one thread alone posts, its next post() succeeds after false. Thread-safe.
  [[nodiscard]] bool full() const;

 private:
  struct Shared;
  static void run(const std::shared_ptr<Shared>& shared, const std::string& name);

  std::shared_ptr<Shared> shared_;
  std::thread thread_;
};

}  // namespace dwell::record
