// Makes pipelines in advance, and destroys those that are given up. Both take tens of milliseconds, too long for the
// estimation thread.
//
// A thread of its own keeps one pipeline ready. In virtual time there is no such thread: everything is done at once.
#pragma once

#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <functional>
#include <memory>
#include <semaphore>
#include <thread>

#include "daemon/estimate/run_pipeline.hpp"

namespace dwell {

// The constructor and the destructor belong to the owner; take(), take_now() and give_up() to the estimation thread.
class Nursery {
 public:
  using Make = std::function<std::unique_ptr<RunPipeline>()>;

  // make: must not throw; with `aside` it is called on the nursery's thread.
  Nursery(Make make, bool aside);
  ~Nursery();
  Nursery(const Nursery&) = delete;
  Nursery& operator=(const Nursery&) = delete;

  // A ready pipeline; null: there is none yet. Real-time safe with a thread of its own.
  [[nodiscard]] std::unique_ptr<RunPipeline> take();
  // As take(), but makes one if none is ready: 25 ms for 64 channels.
  [[nodiscard]] std::unique_ptr<RunPipeline> take_now();
  // The pipeline is no longer needed. Real-time safe with a thread of its own.
  void give_up(std::unique_ptr<RunPipeline> pipeline);

 private:
  // Most pipelines that wait to be destroyed. More would wait only if operators started and stopped many times a
  // second; a pipeline beyond this number is destroyed at once.
  static constexpr std::size_t kLeaving = 8;

  void run();

  const Make make_;
  boost::lockfree::spsc_queue<RunPipeline*, boost::lockfree::capacity<1>> stock_;
  boost::lockfree::spsc_queue<RunPipeline*, boost::lockfree::capacity<kLeaving>> leaving_;
  std::counting_semaphore<> bell_{0};
  std::atomic<bool> stop_{false};
  std::thread thread_;  // none: all is done at once
};

}  // namespace dwell
