#include "daemon/ctl/half_written.hpp"

#include <gtest/gtest.h>

#include <csignal>

namespace dwell::ctl {
namespace {

TEST(HalfWrittenFiles, EndWhereTheWorkLooksForTheSignal) {
  for (const int signal : {SIGINT, SIGTERM}) {
    const HalfWritten half_written;
    EXPECT_NO_THROW(HalfWritten::check());
    std::raise(signal);
    try {
      HalfWritten::check();
      ADD_FAILURE() << "went on";
    } catch (const AskedToEnd& asked) {
      EXPECT_EQ(asked.signal, signal);
    }
  }
}

TEST(HalfWrittenFiles, ThenTheProgramEndsAsTheSignalWouldHaveEndedIt) {
  EXPECT_EXIT(
      {
        try {
          const HalfWritten half_written;
          std::raise(SIGTERM);
          HalfWritten::check();
        } catch (const AskedToEnd& asked) {
          end_by(asked);
        }
      },
      testing::KilledBySignal(SIGTERM), "");
}

}  // namespace
}  // namespace dwell::ctl
