// The out-of-tree example, built against the installed headers alone and found through $DWELL_DRIVER_PATH. Run by
// example.cmake, which builds it first.
#include <gtest/gtest.h>

#include <cmath>

#include "daemon/acquire/plugin.hpp"
#include "tests/drivers/fake_host.hpp"
#include "tests/drivers/given.hpp"

namespace dwell::test {
namespace {

TEST(ExampleDriver, IsLoadedAndDelivers) {
  const auto table = acquire::load_plugin("sine");
  ASSERT_TRUE(table) << table.error();
  Given given("example");
  given.set("frequency", 4.0).set("rate", 200).channel("y0").set("amplitude", 0.005).channel("y1");
  EXPECT_TRUE(mistakes_of(**table, *given.settings()).empty());
  FakeHost host;
  Instance instance(**table, *given.settings(), host);
  ASSERT_TRUE(instance.exists()) << instance.error();
  ASSERT_TRUE(instance.start()) << instance.error();
  ASSERT_TRUE(eventually([&] { return host.sample_count() >= 40; }));
  EXPECT_LT(instance.stop(), 0.5);
  for (const dwell_sample& sample : host.samples(10)) EXPECT_LE(std::fabs(sample.raw), 0.005);
}

TEST(ExampleDriver, StatesHowOldItsSamplesMayBe) {
  const auto table = acquire::load_plugin("sine");
  ASSERT_TRUE(table) << table.error();
  Given given("example");
  given.set("frequency", 4.0).channel("y0");
  dwell_traits traits{};
  traits.size = sizeof traits;
  (*table)->describe(given.settings(), &traits);
  EXPECT_EQ(traits.age_ns, 1'000'000);
  EXPECT_EQ(traits.rate_hz, 100.0);
}

TEST(ExampleDriver, ReportsItsMistakes) {
  const auto table = acquire::load_plugin("sine");
  ASSERT_TRUE(table) << table.error();
  Given given("example");
  given.set("frequency", 400.0).set("rate", 200);
  EXPECT_EQ(mistakes_of(**table, *given.settings()).size(), 1U);
}

}  // namespace
}  // namespace dwell::test
