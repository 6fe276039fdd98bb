// clang-format off
#include <utility>
// clang-format on

#include "daemon/serve/event_loop.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <list>
#include <memory>

namespace dwell {

namespace asio = boost::asio;

struct EventLoop::Impl {
  struct Watch {
    Watch(asio::io_context& context, int watched, std::function<void()> then)
        : descriptor(context, watched), ready(std::move(then)) {}
    Watch(const Watch&) = delete;
    Watch& operator=(const Watch&) = delete;
    asio::posix::stream_descriptor descriptor;
    std::function<void()> ready;
    std::weak_ptr<void> awaited{};
    ~Watch() { descriptor.release(); }  // not ours to close
  };
  struct Timer {
    asio::steady_timer timer;
    std::chrono::milliseconds period;
    std::function<void()> due;
    std::weak_ptr<void> awaited{};
  };

  asio::io_context context{1};
  std::list<Watch> watches;
  std::list<Timer> timers;

  // Where memory ends within Asio a handler is never called; that `awaited` has expired is then all there is to see.
  void await_forgotten() {
    for (Watch& watch : watches)
      if (watch.awaited.expired()) await(watch);
    for (Timer& timer : timers)
      if (timer.awaited.expired()) await(timer);
  }

  static void await(Watch& watch) {
    const auto token = std::make_shared<char>();
    watch.awaited = token;
    watch.descriptor.async_wait(asio::posix::stream_descriptor::wait_read,
                                [&watch, token](const boost::system::error_code& error) {
                                  if (error) return;
                                  await(watch);
                                  watch.ready();
                                });
  }

  static void await(Timer& timer) {
    const auto token = std::make_shared<char>();
    timer.awaited = token;
    timer.timer.async_wait([&timer, token](const boost::system::error_code& error) {
      if (error) return;
      // From now on, not from when it was due: after a pause of the whole machine no burst follows.
      timer.timer.expires_after(timer.period);
      await(timer);
      timer.due();
    });
  }
};

EventLoop::EventLoop() : impl_(std::make_unique<Impl>()) {}
EventLoop::~EventLoop() = default;

void EventLoop::on_readable(int descriptor, std::function<void()> ready) {
  impl_->watches.emplace_back(impl_->context, descriptor, std::move(ready));
  Impl::await(impl_->watches.back());
}

void EventLoop::every(std::chrono::milliseconds period, std::function<void()> due) {
  impl_->timers.push_back({asio::steady_timer(impl_->context, period), period, std::move(due)});
  Impl::await(impl_->timers.back());
}

void EventLoop::run(const std::function<void(const char*)>& failed) {
  const auto keep = asio::make_work_guard(impl_->context);
  while (!impl_->context.stopped()) {
    try {
      impl_->await_forgotten();
      impl_->context.run();
    } catch (const std::exception& failure) {
      failed(failure.what());
    }
  }
}

void EventLoop::stop() { impl_->context.stop(); }

void EventLoop::post(std::function<void()> work) { asio::post(impl_->context, std::move(work)); }

asio::io_context& EventLoop::context() noexcept { return impl_->context; }

}  // namespace dwell
