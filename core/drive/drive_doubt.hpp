// For how long has it been in doubt that the drive is as its reference says?
//
// Every quarter of a period a look is taken at the change over the last quarters; what lies far back is looked at only
// in a far look, now and then, and stands until the next. Another frequency is seen within two periods; a phase that
// slips for longer is a drive that drifts, and no doubt.
//
// Bound to one thread; real-time safe.
#pragma once

#include <algorithm>

namespace dwell {

class DriveDoubt {
 public:
  void restart() noexcept { *this = {}; }

  // A look begins.
  void begin(bool far) noexcept {
    now_ = {};
    far_look_ = far;
    if (far) far_ = {};
  }
  // What it sees: amplitude or phase are in doubt, by quarters that lie far back or by the newest.
  void see(bool amplitude, bool phase, bool far_back) noexcept {
    now_.add({amplitude, phase});
    if (far_back) far_.add({amplitude, phase});
  }
  // It ends.
  void end() noexcept {
    if (!far_look_) now_.add(far_);
    amplitude_ = now_.amplitude ? amplitude_ + 1 : 0;
    phase_ = now_.phase ? phase_ + 1 : 0;
  }

  // Looks, up to the last, at which the amplitude was in doubt; at which either was.
  [[nodiscard]] int amplitude() const noexcept { return amplitude_; }
  [[nodiscard]] int quarters() const noexcept { return std::max(amplitude_, phase_ <= kSlips ? phase_ : 0); }

 private:
  static constexpr int kSlips = 8;  // quarters of a period
  struct Seen {
    bool amplitude = false, phase = false;
    void add(const Seen& other) noexcept {
      amplitude = amplitude || other.amplitude;
      phase = phase || other.phase;
    }
  };
  Seen now_, far_;  // now_: of the present look; far_: of the last look at quarters that lie far back
  bool far_look_ = false;
  int amplitude_ = 0, phase_ = 0;
};

}  // namespace dwell
