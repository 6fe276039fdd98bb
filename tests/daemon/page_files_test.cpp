// The operators' page over HTTP: what is served, and what never is.
#include "daemon/serve/page_files.hpp"

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "daemon/serve/gzip.hpp"
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

std::string unpacked(const std::string& gzip) {
  std::string bytes(PageFiles::kLargest, '\0');
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, MAX_WBITS + 16), Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzip.data()));
  stream.avail_in = static_cast<uInt>(gzip.size());
  stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
  stream.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  bytes.resize(stream.total_out);
  inflateEnd(&stream);
  return bytes;
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

TEST_F(PageFilesTest, ComeInAThirdOfTheirBytesToWhoTakesGzip) {
  const PageFiles page = PageFiles::read(own_page_folder());
  std::size_t plain = 0, packed = 0;
  for (const std::string_view name : PageFiles::names()) {
    const std::string path = name == "index.html" ? "/" : "/page/" + std::string(name);
    const auto as_is = page.answer(path), gzip = page.answer(path, true);
    ASSERT_TRUE(as_is && gzip) << path;
    EXPECT_EQ(unpacked(gzip->body), as_is->body) << path;
    EXPECT_EQ(gzip->encoding, "gzip");
    EXPECT_EQ(as_is->encoding, "");
    EXPECT_TRUE(as_is->varies && gzip->varies) << "a cache between must tell them apart";
    EXPECT_NE(gzip->tag, as_is->tag);
    EXPECT_EQ(gzip->policy, as_is->policy);
    plain += as_is->body.size();
    packed += gzip->body.size();
  }
  EXPECT_LT(packed, 2 * plain / 5);
}

TEST(Gzip, IsTakenByWhoNamesItAtAWeightAboveZero) {
  for (const char* takes :
       {"gzip", "gzip, deflate, br", "deflate,GZIP", "br;q=1.0, gzip;q=0.8, *;q=0.1", "*", "gzip ; q=0.001", " , gzip"})
    EXPECT_TRUE(accepts_gzip(takes)) << takes;
  for (const char* does_not :
       {"", "identity", "deflate, br", "gzip;q=0", "gzip; q=0.000", "*;q=0", "*, gzip;q=0", "xgzip", "gzipx", ";", ","})
    EXPECT_FALSE(accepts_gzip(does_not)) << does_not;
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
