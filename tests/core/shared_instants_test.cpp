// Errors of instants that the channels of one transaction share.
#include "core/transient/shared_instants.hpp"

#include <gtest/gtest.h>

#include "tests/core/free_motion.hpp"

namespace dwell {
namespace {

struct SeenInstants {
  double first_s, second_s;  // of transactions 0 and 1
};

SeenInstants seen(double instant_u_s, int second_transaction, std::uint64_t seed) {
  FreeMotion motion(seed);
  motion.channels[1].transaction = second_transaction;
  motion.instant_u_s = instant_u_s;
  motion.play(4);
  const std::vector<Complex> poles{FreeMotion::kMode};
  motion.fit_all(0.2, poles);
  SharedInstants instants(2);
  instants.look(motion.fit, motion.now());
  return {instants.u_s(0), instants.u_s(1)};
}

TEST(SharedInstants, TellsHowFarTheyAreOff) {
  // 1500 instants give u to 2 %, 1/√(2·1500), and less well where the noise is as large as what the errors make.
  for (const double u_s : {5e-5, 4e-4})
    for (std::uint64_t seed = 1; seed <= 10; ++seed) EXPECT_NEAR(seen(u_s, 0, seed).first_s, u_s, 0.15 * u_s) << seed;
}

TEST(SharedInstants, OfNoiseAloneSeesNextToNothing) {
  // The noise of one channel is what an error of 30 µs would make.
  for (std::uint64_t seed = 1; seed <= 10; ++seed) EXPECT_LT(seen(0.0, 0, seed).first_s, 1e-5) << seed;
}

TEST(SharedInstants, OfAChannelReadAloneSeesNothing) {
  const SeenInstants alone = seen(4e-4, 1, 1);
  EXPECT_EQ(alone.first_s, 0.0);
  EXPECT_EQ(alone.second_s, 0.0);
}

}  // namespace
}  // namespace dwell
