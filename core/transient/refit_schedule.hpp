// Decides when the natural oscillations of a hold are fitted anew: at once, at an instant, or never again in this hold.
// Keeps when the last refit was made, and whether a verdict waits for a second one.
#pragma once

#include <cstdint>
#include <optional>

namespace dwell {

// Bound to one thread, real-time safe. Instants in ns.
class RefitSchedule {
 public:
  // Growth of the hold that asks for another fit: before a verdict, and before a sudden claim is believed.
  static constexpr double kAgain = 0.05;

  // A new hold: nothing is fitted yet, the first refit is due at once.
  void begin_hold() noexcept { *this = {}; }

  [[nodiscard]] bool due(std::int64_t now_ns) const noexcept;
  void plan(std::int64_t at_ns) noexcept;
  // Plans a refit for when the data since free_since_ns have grown by that factor.
  void plan_growth(double growth, std::int64_t free_since_ns, std::int64_t now_ns) noexcept;
  // Plans a refit for that instant unless one is due before.
  void plan_no_later_than(std::int64_t at_ns) noexcept;
  void plan_no_more() noexcept { next_ = Next::never; }
  // When the next refit is due. Valid while one is planned for an instant.
  [[nodiscard]] std::int64_t planned_ns() const noexcept { return at_ns_; }

  // Notes a refit: the poles have been refined on all data until now.
  void made(std::int64_t now_ns) noexcept { made_ns_ = now_ns; }
  // Notes that the hold could not be fitted.
  void failed() noexcept { made_ns_.reset(); }
  // When the last refit of this hold was made; empty: there is no fit.
  [[nodiscard]] const std::optional<std::int64_t>& made_ns() const noexcept { return made_ns_; }

  // What a fit says is left of the transient, relative to what is allowed.
  struct Claim {
    double left;
    double left_before;  // by the judgement before
    bool rounded;        // rounding hides the noise of a channel
  };
  // Whether to believe that no more than allowed is left. Rounding may mislead one fit. So a sudden claim from rounded
  // readings is believed only if it still holds after a refit a little later, planned here.
  bool believes(const Claim& claim, double period_s, std::int64_t free_since_ns, std::int64_t now_ns) noexcept;
  // When a waiting claim will be believed if it still holds; empty: none waits.
  [[nodiscard]] const std::optional<std::int64_t>& confirm_ns() const noexcept { return confirm_ns_; }

 private:
  enum class Next { at_once, at_instant, never };

  Next next_ = Next::at_once;
  std::int64_t at_ns_ = 0;  // of Next::at_instant
  std::optional<std::int64_t> made_ns_, confirm_ns_;
};

}  // namespace dwell
