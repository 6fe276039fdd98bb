// clang-format off
#include <utility>
// clang-format on

#include "daemon/serve/event_loop.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <list>

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
    ~Watch() { descriptor.release(); }  // not ours to close
  };
  struct Timer {
    asio::steady_timer timer;
    std::chrono::milliseconds period;
    std::function<void()> due;
  };

  asio::io_context context{1};
  std::list<Watch> watches;
  std::list<Timer> timers;

  static void await(Watch& watch) {
    watch.descriptor.async_wait(asio::posix::stream_descriptor::wait_read,
                                [&watch](const boost::system::error_code& error) {
                                  if (error) return;
                                  await(watch);
                                  watch.ready();
                                });
  }

  static void await(Timer& timer) {
    timer.timer.async_wait([&timer](const boost::system::error_code& error) {
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
