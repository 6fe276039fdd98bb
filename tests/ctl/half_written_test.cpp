#include "daemon/ctl/half_written.hpp"

#include <gtest/gtest.h>

#include <csignal>

namespace dwell::ctl {
namespace {

// Whoever starts the tests in the background may have them ignore SIGINT.
struct HalfWrittenFiles : testing::TestWithParam<int> {
  HalfWrittenFiles() : before(std::signal(GetParam(), SIG_DFL)) {}
  ~HalfWrittenFiles() override { std::signal(GetParam(), before); }
  void (*const before)(int);
};

TEST_P(HalfWrittenFiles, EndWhereTheWorkLooksForTheSignal) {
  const HalfWritten half_written;
  EXPECT_NO_THROW(HalfWritten::check());
  std::raise(GetParam());
  try {
    HalfWritten::check();
    ADD_FAILURE() << "went on";
  } catch (const AskedToEnd& asked) {
    EXPECT_EQ(asked.signal, GetParam());
  }
}

TEST_P(HalfWrittenFiles, ThenTheProgramEndsAsTheSignalWouldHaveEndedIt) {
  EXPECT_EXIT(
      {
        try {
          const HalfWritten half_written;
          std::raise(GetParam());
          HalfWritten::check();
        } catch (const AskedToEnd& asked) {
          end_by(asked);
        }
      },
      testing::KilledBySignal(GetParam()), "");
}

TEST_P(HalfWrittenFiles, GoOnWhereTheSignalIsIgnored) {
  std::signal(GetParam(), SIG_IGN);
  const HalfWritten half_written;
  std::raise(GetParam());
  EXPECT_NO_THROW(HalfWritten::check());
}

INSTANTIATE_TEST_SUITE_P(Signals, HalfWrittenFiles, testing::Values(SIGINT, SIGTERM, SIGHUP));

}  // namespace
}  // namespace dwell::ctl
