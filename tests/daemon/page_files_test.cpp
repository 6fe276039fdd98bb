// The operators' page over HTTP: what is served, and what never is.
#include "daemon/serve/page_files.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "daemon/serve/http_request.hpp"

namespace dwell {
namespace {

namespace fs = std::filesystem;

std::set<std::string> names_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (!entry.is_directory()) names.insert(fs::relative(entry.path(), folder).string());
  return names;
}

struct PageFilesTest : testing::Test {
  void TearDown() override { fs::remove_all(folder); }
  const fs::path folder = fs::temp_directory_path() / ("dwell_page_" + std::to_string(getpid()));
};

TEST_F(PageFilesTest, AreExactlyThoseOfTheFolderBesideTheProgram) {
  const std::string own = own_page_folder();
  const PageFiles page = PageFiles::read(own);
  EXPECT_EQ(page.trouble(), "");
  EXPECT_EQ(names_in(fs::canonical(own)), std::set<std::string>(PageFiles::names().begin(), PageFiles::names().end()));
}

TEST_F(PageFilesTest, SayWhatTheyAreAndLetNothingForeignIn) {
  const PageFiles page = PageFiles::read(own_page_folder());
  for (const auto& [path, type] :
       {std::pair("/", "text/html; charset=utf-8"), std::pair("/page/page.css", "text/css; charset=utf-8"),
        std::pair("/page/main.mjs", "text/javascript; charset=utf-8"), std::pair("/page/icon.svg", "image/svg+xml")}) {
    const auto reply = page.answer(path);
    ASSERT_TRUE(reply) << path;
    EXPECT_EQ(reply->status, 200);
    EXPECT_EQ(reply->content_type, type);
    EXPECT_EQ(reply->policy.rfind("default-src 'self'; ", 0), 0U) << reply->policy;
    EXPECT_EQ(reply->policy.find("unsafe"), std::string::npos);
    EXPECT_GT(reply->body.size(), 100U);
    EXPECT_EQ(reply->tag.front(), '"');
  }
}

TEST_F(PageFilesTest, NoPathReachesAnotherFile) {
  const PageFiles page = PageFiles::read(own_page_folder());
  for (const char* path : {"/page/../serve/api.cpp", "/page/%2e%2e/README.md", "/page//main.mjs", "/page/", "/page",
                           "/main.mjs", "/page/index.html", "//", "/page/main.mjs/", "/api/v1/dwell"})
    EXPECT_FALSE(page.answer(path)) << path;
}

TEST_F(PageFilesTest, AFolderThatLacksOneLeavesNoPageAndTheSlashSaysWhich) {
  fs::create_directories(folder);
  for (const std::string_view name : PageFiles::names())
    if (name != "page.css") std::ofstream(folder / name) << "x";
  const PageFiles page = PageFiles::read(folder.string());
  const auto reply = page.answer("/");
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->status, 404);
  EXPECT_NE(reply->body.find("page.css cannot be read"), std::string::npos) << reply->body;
  EXPECT_NE(reply->body.find("/api/v1"), std::string::npos) << reply->body;
  EXPECT_FALSE(page.answer("/page/main.mjs"));
  EXPECT_FALSE(page.answer("/api/v1/dwell"));
}

TEST_F(PageFilesTest, AreReadOnceAndNotAgain) {
  fs::create_directories(folder);
  for (const std::string_view name : PageFiles::names()) std::ofstream(folder / name) << "before";
  const PageFiles page = PageFiles::read(folder.string());
  fs::remove_all(folder);
  EXPECT_EQ(page.answer("/")->body, "before");
}

TEST_F(PageFilesTest, OneThatIsTooLargeIsNotTaken) {
  fs::create_directories(folder);
  for (const std::string_view name : PageFiles::names()) std::ofstream(folder / name) << "x";
  std::ofstream(folder / "main.mjs") << std::string(PageFiles::kLargest + 1, 'x');
  EXPECT_NE(PageFiles::read(folder.string()).trouble(), "");
}

TEST(HttpReply, IsNotSentAgainToWhoHasItsBytes) {
  const HttpReply page{200, "bytes", "text/html", "\"tag\"", ""};
  HttpRequest request;
  EXPECT_EQ(unless_known(page, request).status, 200);
  request.known = "\"other\"";
  EXPECT_EQ(unless_known(page, request).body, "bytes");
  request.known = "\"other\", W/\"tag\"";
  EXPECT_EQ(unless_known(page, request).status, 304);
  EXPECT_EQ(unless_known(page, request).body, "");
  const HttpReply news{200, "{}"};
  EXPECT_EQ(unless_known(news, request).status, 200);
}

}  // namespace
}  // namespace dwell
