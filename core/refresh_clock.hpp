// At which instants is a register refreshed that is read more often than that?
//
// A new value that one reading shows and the reading before did not was refreshed in between. A device refreshes at a
// constant rate, t(k + 1) = t(k) + T, so each new value bounds the newest instant t and the period T from both sides:
//
//   after < t ≤ by,   t(k + m) = t(k) + m T
//
// What satisfies all of these is a convex polygon in the plane (t, T). It is moved on by one refresh, clipped by its
// two bounds, and its extent in t is what is known of the instant: the reading's interval at first, after n refreshes
// about 1/n of it where the rates are no simple ratio. Where they are (every fourth reading is new), only the interval
// between two readings is known, and the polygon says so.
//
// Real devices jitter: each bound is relaxed by that much. Where nothing satisfies the bounds any more, the jitter is
// larger than was thought: all begins anew, with twice as much. Beyond half of the interval between readings the
// register has no rate, and the two readings are all that is known.
//
// A gateway that repeats readings at random fits for a while as well. So the clock counts only once kBelieved new
// values that came after repeats have fitted; until then the two readings tell.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace dwell {

// Of one channel. Bound to one thread; real-time safe; some 100 multiplications a refresh. Copies are independent.
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
  [[nodiscard]] bool believed() const noexcept { return repeats_ >= kBelieved; }

 private:
  struct Vertex {
    double t, T;  // ns; t relative to origin_ns_
  };
  // Vertices kept, and room for the two that each of the two bounds may add. Some ten are usual.
  // Random repeats fit by chance one after the other: of one reading in twenty once in 10^6, of one in three once in
  // 250.
  static constexpr int kBelieved = 8;
  static constexpr std::size_t kEnough = 24, kMost = kEnough + 4;
  struct Polygon {
    std::array<Vertex, kMost> at{};
    std::size_t count = 0;
  };
  void begin(double after, double by) noexcept;
  // The part of `in` on the side sign·t ≤ sign·bound.
  static void clip(Polygon& in, double sign, double bound) noexcept;
  // Moves on by so many refreshes, the last of them in between. false: that cannot be, and nothing has changed.
  bool advance(double refreshes, double after, double by) noexcept;
  void thin_out() noexcept;
  void wander(double elapsed_ns) noexcept;

  Polygon known_;
  std::int64_t origin_ns_ = 0;  // by_ns of the newest
  double jitter_ns_ = 0.0;
  int since_ = 0, repeats_ = 0;  // since all began anew: refreshes, and those that came after repeats
};

}  // namespace dwell
