#include "core/base/slices.hpp"

#include <algorithm>
#include <boost/context/fiber.hpp>
#include <boost/context/protected_fixedsize_stack.hpp>
#include <cassert>
#include <limits>
#include <utility>

namespace dwell {
namespace {

// Stack size, bytes. A guard page lies below the stack; unused pages cost no memory. The deepest work, the end of a
// dwell of 64 masses, uses less than a tenth.
constexpr std::size_t kStack = std::size_t{1} << 22;

// The thread sanitizer does not follow a change of stacks. Under this sanitizer the work runs in one slice.
#if defined(__SANITIZE_THREAD__)
constexpr bool kOwnStack = false;
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
constexpr bool kOwnStack = false;
#else
constexpr bool kOwnStack = true;
#endif
#else
constexpr bool kOwnStack = true;
#endif

}  // namespace

struct Slices::Stack {
  boost::context::fiber inside, outside;
  bool ends = false;
};

Slices::Slices(std::function<void()> work) : work_(std::move(work)), stack_(std::make_unique<Stack>()) {
  if constexpr (!kOwnStack) return;
  stack_->inside = {std::allocator_arg, boost::context::protected_fixedsize_stack(kStack),
                    [this](boost::context::fiber&& outside) {
                      stack_->outside = std::move(outside);
                      while (!stack_->ends) {
                        work_();
                        busy_ = false;
                        stack_->outside = std::move(stack_->outside).resume();
                      }
                      return std::move(stack_->outside);
                    }};
}

Slices::~Slices() {
  if constexpr (!kOwnStack) return;
  allow_all();
  if (busy_) go_on();
  stack_->ends = true;
  stack_->inside = std::move(stack_->inside).resume();
}

void Slices::allow(double work, double most) noexcept { left_ = std::min(left_ + work, most); }

void Slices::allow_all() noexcept { left_ = std::numeric_limits<double>::infinity(); }

bool Slices::begin() noexcept {
  assert(!busy_);
  busy_ = true;
  return go_on();
}

bool Slices::go_on() noexcept {
  assert(busy_);
  if (!kOwnStack) {
    work_();
    busy_ = false;
    return true;
  }
  inside_ = true;
  stack_->inside = std::move(stack_->inside).resume();
  inside_ = false;
  return !busy_;
}

void Slices::pause() noexcept { stack_->outside = std::move(stack_->outside).resume(); }

}  // namespace dwell
