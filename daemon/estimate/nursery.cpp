#include "daemon/estimate/nursery.hpp"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <utility>

namespace dwell {
namespace {

// A birth is due every 10 s and takes 25 ms, so this thread may wait for all others.
constexpr int kNurseryNice = 10;

}  // namespace

Nursery::Nursery(Make make, bool aside) : make_(std::move(make)) {
  if (aside) thread_ = std::thread([this] { run(); });
}

Nursery::~Nursery() {
  stop_.store(true);
  bell_.release();
  if (thread_.joinable()) thread_.join();
  const auto discard = [](RunPipeline* pipeline) { delete pipeline; };
  stock_.consume_all(discard);
  leaving_.consume_all(discard);
}

std::unique_ptr<RunPipeline> Nursery::take() {
  if (!thread_.joinable()) return make_();
  RunPipeline* ready = nullptr;
  if (stock_.pop(ready)) bell_.release();
  return std::unique_ptr<RunPipeline>(ready);
}

std::unique_ptr<RunPipeline> Nursery::take_now() {
  auto ready = take();
  return ready ? std::move(ready) : make_();
}

void Nursery::give_up(std::unique_ptr<RunPipeline> pipeline) {
  if (!thread_.joinable() || !leaving_.push(pipeline.get())) return;
  (void)pipeline.release();
  bell_.release();
}

void Nursery::run() {
  pthread_setname_np(pthread_self(), "nursery");
  // On Linux this sets the priority of this thread alone. If it is refused, the work is done at the usual priority.
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNurseryNice);
  while (!stop_.load()) {
    leaving_.consume_all([](RunPipeline* pipeline) { delete pipeline; });
    if (stock_.write_available() > 0) {
      auto made = make_();
      if (stock_.push(made.get())) (void)made.release();
    }
    bell_.acquire();
  }
}

}  // namespace dwell
