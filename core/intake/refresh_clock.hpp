// At which instants is a register refreshed that is read more often than that?
//
// A new value that one reading shows and the reading before did not was refreshed in between. A device refreshes at a
// constant rate, t(k + 1) = t(k) + T, so each new value bounds the newest instant t and the period T from both sides:
//
//   after < t ≤ by,   t(k + m) = t(k) + m T
//
// What satisfies all of these is a convex polygon in the plane (t, T). It is moved on by one refresh, clipped by its
// two bounds, and its extent in t is what is known of the instant: the reading's interval at first, after n refreshes
// about 1/n of it where the rates are no simple ratio. Where p readings are as long as q refreshes (in lowest terms),
// the refreshes fall on q places of the polling interval only, and the instant is known to ± 1/(2q) of it: with every
// fourth reading new (q = 1) nothing but the two readings, with two of three (q = 2) ± a quarter. The polygon says so.
//
// Real devices jitter: each bound is relaxed by that much. Where nothing satisfies the bounds any more, the jitter is
// larger than was thought: all begins anew, with twice as much. From half of the usual polling interval on the register
// has no rate, and the two readings are all that is known. A gap in polling says nothing of the jitter. The clock
// counts the refreshes within it; where it is not known well enough for that, the newest is at most one period old.
// The same holds for a rig that stands still, where every refresh brings the same value; but there all begins anew.
//
// The period wanders: between two refreshes the polygon grows by as much in ± T, whatever its shape.
//
// A gateway that repeats readings at random fits for a while as well. So the clock counts only once kBelieved new
// values that came after repeats have fitted; until then the two readings tell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dwell {

// Of one channel. Bound to one thread; real-time safe; about 0.5 µs a refresh. Copies are independent.
class RefreshClock {
 public:
  struct Instant {
    std::int64_t t_ns = 0;
    std::uint32_t half_ns = 0;  // half width: the refresh was at t ± half, within the two readings
  };

  // The next new value was refreshed after the reading at `after` and by the one at `by`; after < by, and not before
  // the `by` of the value before.
  Instant refreshed(std::int64_t after_ns, std::int64_t by_ns) noexcept;
  // Whether the instants that are given out are those of a clock.
  [[nodiscard]] bool believed() const noexcept;

 private:
  struct Vertex {
    double t, T;  // ns; t relative to origin_ns_
  };
  // Refreshes after repeats that must fit before the clock is used. Random repeats (1 in 3) pass 8 in a row once in
  // 250.
  static constexpr int kBelieved = 8;
  // kEnough: vertices kept; with 24 no half width of the tests is smaller, with 10 they are 0.5 % larger. kMost: plus
  // two for the wandering period and two for each of the two bounds.
  static constexpr std::size_t kEnough = 16, kMost = kEnough + 6;
  struct Polygon {
    std::array<Vertex, kMost> at{};
    std::size_t count = 0;
    // Rounding may bend a side inwards, and a bound may cross it there: never beyond the room.
    void keep(Vertex vertex) noexcept {
      if (count < kMost) at[count++] = vertex;
    }
  };
  void begin(double after, double by) noexcept;
  // The part of `in` on the side sign·t ≤ sign·bound.
  static void clip(Polygon& in, double sign, double bound) noexcept;
  // Moves on by so many refreshes, the last of them in between. false: that cannot be, and nothing has changed.
  bool advance(double refreshes, double after, double by) noexcept;
  void lose_count(double interval, double jitter) noexcept;
  void thin_out() noexcept;
  static void enclose(Polygon& what) noexcept;
  void wander(double elapsed_ns) noexcept;

  Polygon known_;
  std::int64_t origin_ns_ = 0;   // by_ns of the newest
  double usual_ns_ = 0.0;        // interval between readings
  double jitter_ = 0.0;          // of the refresh, as a part of it
  int since_ = 0, repeats_ = 0;  // since all began anew: refreshes, and those that came after repeats
};

}  // namespace dwell
