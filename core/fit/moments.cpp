#include "core/fit/moments.hpp"

#include <cassert>
#include <cmath>

namespace dwell::moments {
namespace {

// Turns the padding of each row with the rest, so that all angles go through the registers in twos. `count` is the
// padded length of a row: where the compiler knows it, a turn takes a third less time.
template <int count>
void turn_so_many(const double* __restrict in, const Turn& __restrict turn, double mean_square,
                  double* __restrict out) noexcept {
  for (int k = 0; k < static_cast<int>(stride(count)); ++k) {
    const double c = turn.c[static_cast<std::size_t>(k)], s = turn.s[static_cast<std::size_t>(k)];
    const double a = k * turn.delta, left = 1 - 0.5 * a * a * mean_square;
    const double c0 = in[cosine(count, 0, k)], s0 = in[sine(count, 0, k)];
    const double c1 = in[cosine(count, 1, k)], s1 = in[sine(count, 1, k)];
    const double x0 = left * c0 - a * s1, y0 = left * s0 + a * c1;
    const double x1 = c1 - a * mean_square * s0, y1 = s1 + a * mean_square * c0;
    const double p0 = c * x0 - s * y0, q0 = s * x0 + c * y0;
    const double p1 = c * x1 - s * y1, q1 = s * x1 + c * y1;
    out[cosine(count, 0, k)] += p0;
    out[sine(count, 0, k)] += q0;
    out[cosine(count, 1, k)] += p1 + turn.shift * p0;
    out[sine(count, 1, k)] += q1 + turn.shift * q0;
  }
}

void turn_angles(const double* in, int count, const Turn& turn, double mean_square, double* out) noexcept {
  switch (stride(count)) {
    case 2:
      return turn_so_many<2>(in, turn, mean_square, out);
    case 4:
      return turn_so_many<4>(in, turn, mean_square, out);
    case 6:
      return turn_so_many<6>(in, turn, mean_square, out);
    case 8:
      return turn_so_many<8>(in, turn, mean_square, out);
    case 10:
      return turn_so_many<10>(in, turn, mean_square, out);
    case 12:
      return turn_so_many<12>(in, turn, mean_square, out);
    case 14:
      return turn_so_many<14>(in, turn, mean_square, out);
    case 16:
      return turn_so_many<16>(in, turn, mean_square, out);
    case 18:
      return turn_so_many<18>(in, turn, mean_square, out);
    default:
      assert(false && "more angles than a Turn has");
  }
}

}  // namespace

Turn::Turn(double faster, double phase, double later, int count) noexcept : delta(faster), shift(later) {
  c[0] = 1.0, s[0] = 0.0;
  const double one_c = std::cos(phase), one_s = std::sin(phase);
  for (std::size_t k = 1; k < static_cast<std::size_t>(count); ++k) {
    c[k] = c[k - 1] * one_c - s[k - 1] * one_s;
    s[k] = c[k - 1] * one_s + s[k - 1] * one_c;
  }
}

void add_instants(const double* in, int count, const Turn& turn, double* out) noexcept {
  turn_angles(in, count, turn, mean_square_u(in, count), out);
  out[squares(count)] += in[squares(count)] + turn.shift * (2 * in[cosine(count, 1, 0)] + turn.shift * in[0]);
}

void add_readings(const double* in, int count, const Turn& turn, double mean_square, double* out) noexcept {
  turn_angles(in, count, turn, mean_square, out);
  out[squares(count)] += in[squares(count)];
}

}  // namespace dwell::moments
