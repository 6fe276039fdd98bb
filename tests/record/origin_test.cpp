// What a run file says of the program that recorded it.
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "daemon/record/run_entries.hpp"

namespace dwell::record {
namespace {

std::string printed(const std::string& command) {
  std::string text;
  FILE* const pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  ::pclose(pipe);
  return text;
}

TEST(Origin, NamesTheSourcesByTheSumThatACheckoutGives) {
  const std::string sum =
      printed("cd '" DWELL_SOURCE
              "' && find core config daemon drivers -name '*.[ch]pp' | LC_ALL=C sort | xargs sha256sum | sha256sum");
  ASSERT_EQ(sum.size(), 64U + 4U) << sum;
  const std::string expected = "sources " + sum.substr(0, 16) + ", ";
  EXPECT_EQ(this_origin().build.substr(0, expected.size()), expected);
}

}  // namespace
}  // namespace dwell::record
