// Counts for how long it has been in doubt whether the drive still agrees with its reference.
//
// StepWatch takes a look every quarter of a period: it tests the newest quarters. A far look, once a period, tests
// older quarters too; its doubts about these stand until the next far look. Another frequency is seen within two
// periods. A phase that slips for longer is a drift of the drive and no doubt.
//
// Bound to one thread; real-time safe.
#pragma once

#include <algorithm>

namespace dwell {

class DriveDoubt {
 public:
  void restart() noexcept { *this = {}; }

  // Begins a look. far: it tests old quarters too.
  void begin(bool far) noexcept {
    now_ = {};
    far_look_ = far;
    if (far) far_ = {};
  }
  // Takes one result of the look: whether amplitude and phase are in doubt. far_back: by a change at an old quarter.
  void see(bool amplitude, bool phase, bool far_back) noexcept {
    now_.add({amplitude, phase});
    if (far_back) far_.add({amplitude, phase});
  }
  // Ends the look.
  void end() noexcept {
    if (!far_look_) now_.add(far_);
    amplitude_ = now_.amplitude ? amplitude_ + 1 : 0;
    phase_ = now_.phase ? phase_ + 1 : 0;
  }

  // Consecutive looks, up to the newest, with doubt about the amplitude; about amplitude or phase.
  [[nodiscard]] int amplitude() const noexcept { return amplitude_; }
  [[nodiscard]] int quarters() const noexcept { return std::max(amplitude_, phase_ <= kSlips ? phase_ : 0); }

 private:
  static constexpr int kSlips = 8;  // quarter periods: a phase in doubt for longer is a drift
  struct Seen {
    bool amplitude = false, phase = false;
    void add(const Seen& other) noexcept {
      amplitude = amplitude || other.amplitude;
      phase = phase || other.phase;
    }
  };
  Seen now_, far_;  // doubts of the present look; doubts about old quarters, of the last far look
  bool far_look_ = false;
  int amplitude_ = 0, phase_ = 0;
};

}  // namespace dwell
