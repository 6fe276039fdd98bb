// keygen: makes a key, replaces none.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/ctl/program.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell::ctl {
namespace {

TEST(Keygen, LeavesAPublicKeyThatIsThere) {
  const test::TemporaryFolder folder;
  const std::string own = folder.path("key");
  const std::string pub = folder.file("key.pub", "anna@desk+the only copy\n");
  const test::Outcome refused = test::run({"keygen", "--key", own});
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find(pub + ": exists already; a key is not replaced"), std::string::npos) << refused.err;
  EXPECT_EQ(test::contents(pub), "anna@desk+the only copy\n");
  EXPECT_FALSE(std::filesystem::exists(own));
}

}  // namespace
}  // namespace dwell::ctl
