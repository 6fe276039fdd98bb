#include "daemon/service_watch.hpp"

#include <gtest/gtest.h>

#include "daemon/log/driver_lines.hpp"
#include "tests/daemon/log_to_read.hpp"
#include "tests/durations.hpp"

namespace dwell {
namespace {

TEST(ServiceWatch, SaysOnceThatTheServiceDoesNotWorkAndOnceThatItDoesAgain) {
  test::LogToRead log("service-watch");
  ServiceWatch watch(log);
  const std::vector<WatchedThread> still{{"estimate", 0, 2 * kSecond_ns}};
  watch.look(1 * kSecond_ns, still, {});
  EXPECT_EQ(watch.trouble(), "");
  watch.look(3 * kSecond_ns, still, {});
  watch.look(4 * kSecond_ns, still, {});
  EXPECT_EQ(watch.trouble(), "thread estimate has not turned for 4.0 s");
  watch.look(5 * kSecond_ns, {{"estimate", 5 * kSecond_ns, 2 * kSecond_ns}}, {});
  EXPECT_EQ(watch.trouble(), "");
  EXPECT_EQ(log.lines(), (std::vector<std::string>{
                             "error the service does not work: thread estimate has not turned for 3.0 s",
                             "info the service works again",
                         }));
}

TEST(DriverLines, StandUnderTheirDevicesNameAtTheirLevel) {
  test::LogToRead log("driver-lines");
  DriverLines lines("amplifier", log);
  lines.line(DWELL_WARNING, "register 7 is read twice", kSecond_ns);
  EXPECT_EQ(log.lines(), std::vector<std::string>{"warning device amplifier: register 7 is read twice"});
}

TEST(DriverLines, BeyondSoManyASecondAreCountedAndSaidInTheNext) {
  test::LogToRead log("driver-lines-many");
  DriverLines lines("amplifier", log);
  for (int i = 0; i < DriverLines::kLinesPerSecond + 30; ++i) lines.line(DWELL_INFO, "again", kSecond_ns + i);
  lines.line(DWELL_INFO, "another second", 2 * kSecond_ns);
  const auto written = log.lines();
  ASSERT_EQ(written.size(), DriverLines::kLinesPerSecond + 2u);
  EXPECT_EQ(written[DriverLines::kLinesPerSecond], "warning device amplifier: 30 lines of its driver left out");
  EXPECT_EQ(written.back(), "info device amplifier: another second");
}

}  // namespace
}  // namespace dwell
