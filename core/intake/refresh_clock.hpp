// Recovers the instants at which a held register is refreshed. Such a register is read more often than refreshed.
//
// A new value was refreshed between the reading that shows it first and the reading before. A device refreshes at a
// constant rate, t(k + 1) = t(k) + T. So each new value bounds the newest instant t and the period T from both sides:
//
//   after < t ≤ by,   t(k + m) = t(k) + m T
//
// The solutions of all bounds form a convex polygon in the plane (t, T). Each refresh moves it on and clips it by two
// bounds. Its extent in t is the uncertainty of the instant: at first the interval of the readings, after n refreshes
// about 1/n of it where the rates are no simple ratio. If p readings take as long as q refreshes (in lowest terms), the
// refreshes fall on only q places of the polling interval. The instant is then known to ± 1/(2q) of it: with every
// fourth reading new (q = 1) no better than the two readings, with two of three (q = 2) to ± a quarter.
//
// Real devices jitter: each bound is relaxed by the jitter. If no solution remains, the jitter is larger than thought:
// everything begins anew, with twice the jitter. From half of the usual polling interval on the register has no rate,
// and only the two readings bound the instant. A gap in polling says nothing of the jitter. The clock counts the
// refreshes within the gap; if it is not known well enough for that, the newest is at most one period old. While the
// rig stands still every refresh brings the same value. The clock counts these refreshes likewise; where it cannot,
// everything begins anew.
//
// The period wanders: between two refreshes the polygon grows in ± T.
//
// A gateway that repeats readings at random also fits for a while. So the clock is used only once kBelieved new values
// that came after repeats have fitted. Until then the two readings bound the instant.
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
    std::uint32_t half_ns = 0;  // half width: the refresh was at t_ns ± half_ns, between the two readings
  };

  // The next new value: refreshed after the reading at after_ns and by the one at by_ns. after_ns < by_ns, and not
  // before the by_ns of the value before.
  Instant refreshed(std::int64_t after_ns, std::int64_t by_ns) noexcept;
  // Whether the clock gives the instants; false: the two readings alone.
  [[nodiscard]] bool believed() const noexcept;

 private:
  struct Vertex {
    double t, T;  // ns; t relative to origin_ns_
  };
  // Refreshes after repeats that must fit before the clock is used. Random repeats (1 in 3) fit 8 times in a row once
  // in 250.
  static constexpr int kBelieved = 8;
  // kEnough: vertices kept. With 24 no half width of the tests is smaller, with 10 they are 0.5 % larger. kMost: room
  // for two more by the wandering period and two by each of the two bounds.
  static constexpr std::size_t kEnough = 16, kMost = kEnough + 6;
  struct Polygon {
    std::array<Vertex, kMost> at{};
    std::size_t count = 0;
    // Rounding may bend a side inwards. A bound may then cross it there and add vertices: those without room are
    // dropped.
    void keep(Vertex vertex) noexcept {
      if (count < kMost) at[count++] = vertex;
    }
  };
  void begin(double after, double by) noexcept;
  // Keeps the part of `in` with sign·t ≤ sign·bound.
  static void clip(Polygon& in, double sign, double bound) noexcept;
  // Moves on by so many refreshes, the last of them between `after` and `by`. false: impossible; nothing has changed.
  bool advance(double refreshes, double after, double by) noexcept;
  void lose_count(double interval, double jitter) noexcept;
  void thin_out() noexcept;
  static void enclose(Polygon& what) noexcept;
  void wander(double elapsed_ns) noexcept;

  Polygon known_;
  std::int64_t origin_ns_ = 0;   // by_ns of the newest value
  double usual_ns_ = 0.0;        // polling interval
  double jitter_ = 0.0;          // of the refreshes, as a part of usual_ns_
  int since_ = 0, repeats_ = 0;  // since everything began anew: refreshes; those after repeats
};

}  // namespace dwell
