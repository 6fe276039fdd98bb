// Runs long work in slices, so that the caller is never blocked for long.
//
// The work runs on a stack of its own and reports its progress by spend(). It pauses as soon as it has spent more than
// the owner allowed; the owner resumes the work later. Work is counted in multiplications, not in seconds: the same
// work pauses at the same places on every machine.
//
//   slices.allow(work, most);                 in the work:  for (…) { …; slices.spend(products); }
//   done = slices.begin();  …  done = slices.go_on();
#pragma once

#include <functional>
#include <memory>

namespace dwell {

// Bound to one thread. The constructor allocates a stack of 4 MB. begin(), go_on() and spend() are real-time safe.
class Slices {
 public:
  // work: runs once for each begin(); must not throw.
  explicit Slices(std::function<void()> work);
  // Finishes work in progress first, without limit.
  ~Slices();
  Slices(const Slices&) = delete;
  Slices& operator=(const Slices&) = delete;

  // Adds `work` to the allowance, multiplications, and caps the sum at `most`.
  void allow(double work, double most) noexcept;
  // Removes the limit, until the next allow().
  void allow_all() noexcept;
  // Whether any allowance is left.
  [[nodiscard]] bool may_work() const noexcept { return left_ > 0; }

  // Multiplications done beyond the allowance; 0 while some is left. At most the largest amount given to spend().
  [[nodiscard]] double overdrawn() const noexcept { return left_ < 0 ? -left_ : 0.0; }

  // begin() starts the work, only while not busy(); go_on() resumes it, only while busy(). true: the work is done.
  bool begin() noexcept;
  bool go_on() noexcept;
  // Whether work has begun and is not done.
  [[nodiscard]] bool busy() const noexcept { return busy_; }

  // Called by the work: reports `work` multiplications as done. Pauses when the allowance is used up, so it may return
  // much later. Does nothing when called from outside the work.
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
