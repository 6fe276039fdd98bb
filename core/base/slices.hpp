// Long work done in slices, so that it never holds up whoever asked for it.
//
// The work runs on a stack of its own. It says now and then how much of it is done, and pauses where that exceeds what
// it has been allowed; whoever owns the slices lets it go on later. Work is counted in multiplications, not in seconds:
// the same work pauses at the same places on every machine.
//
//   slices.allow(most);                       in the work:  for (…) { …; slices.spend(products); }
//   done = slices.begin();  …  slices.go_on();
#pragma once

#include <functional>
#include <memory>

namespace dwell {

// Bound to one thread. All memory is allocated by the constructor: 4 MB of stack. begin(), go_on() and spend() are
// real-time safe.
class Slices {
 public:
  // work: what each begin() does; must not throw.
  explicit Slices(std::function<void()> work);
  // Work that is not done is done now.
  ~Slices();
  Slices(const Slices&) = delete;
  Slices& operator=(const Slices&) = delete;

  // So much more work may be done, but never more than `most` at once.
  void allow(double work, double most) noexcept;
  // Without limit from now on.
  void allow_all() noexcept;
  // Whether there is any left to do it with.
  [[nodiscard]] bool may_work() const noexcept { return left_ > 0; }

  // By how much more than allowed the work did before it paused: its largest piece bounds it.
  [[nodiscard]] double overdrawn() const noexcept { return left_ < 0 ? -left_ : 0.0; }

  // Begins the work, or goes on with it; whether it is done. begin() only where it is.
  bool begin() noexcept;
  bool go_on() noexcept;
  // Whether it has begun and is not done.
  [[nodiscard]] bool busy() const noexcept { return busy_; }

  // In the work: so much of it is done. May return much later. Outside it does nothing.
  void spend(double work) noexcept {
    if (!inside_) return;
    left_ -= work;
    if (left_ < 0) pause();
  }

 private:
  void pause() noexcept;

  struct Stack;
  std::function<void()> work_;
  std::unique_ptr<Stack> stack_;
  double left_ = 0.0;
  bool busy_ = false, inside_ = false;
};

}  // namespace dwell
