// A run file that somebody made to use up the memory of whoever opens it: signed, valid, and much larger than it looks.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <functional>
#include <vector>

#include "daemon/record/block.hpp"
#include "daemon/record/chain_file.hpp"
#include "tests/api_schema.hpp"
#include "tests/handon/handed_run.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell {
namespace {

// Address space that a verb may take: the program and its libraries map 200 MB of it. To hold what is in the files
// below would take more.
constexpr const char* kLimit_kB = "600000";

class HostileFile : public ::testing::Test {
 protected:
  // The header and the rig file of an honest run, then `fill`.
  template <class Fill>
  void make(const Fill& fill, const std::function<void(record::RunHeader&)>& change = {}) {
    test::HandedRun run;
    run.length_s = 2.0;
    test::write(run, scratch_.path("honest.dwell"));
    const auto key = *record::SigningKey::make("forger");
    record::RunHeader header = test::select(run).header();
    header.vkey = key.public_key().vkey();
    if (change) change(header);
    auto writer = *record::ChainWriter::create(scratch_.path("bomb.dwell"), record::ChainSort::run,
                                               "dwell/run/" + header.id, key);
    ASSERT_TRUE(writer.append("run", 0, to_json(header)));
    fill(writer);
    ASSERT_TRUE(writer.append("end", 0, to_json(record::RunEnd{"operator", 1, 1, header.start_utc})));
    ASSERT_TRUE(writer.close());
  }
  // Each verb that opens a run file ends by itself, and says what is wrong if it cannot do its work.
  void expect_bounded(const std::vector<std::string>& verbs) const {
    for (const std::string& verb : verbs) {
      const std::string command = "cd " + scratch_.path() + " && ulimit -v " + kLimit_kB + " && " DWELLCTL " " + verb +
                                  " >said.out 2>said.err </dev/null";
      const int status = std::system(command.c_str());
      const std::string said = record::Scratch::read(scratch_.path("said.err"));
      ASSERT_TRUE(WIFEXITED(status)) << verb;
      EXPECT_LE(WEXITSTATUS(status), 2) << verb << ": " << said;
      EXPECT_EQ(said.find("bad_alloc"), std::string::npos) << verb << ": " << said;
      EXPECT_EQ(said.find("memory"), std::string::npos) << verb << ": " << said;
    }
  }

  record::Scratch scratch_;
};

TEST_F(HostileFile, OfBlocksThatAreAllZerosTakesNoMemory) {
  if (kUnderSanitizer) GTEST_SKIP() << "a sanitizer takes address space of its own";
  make([](record::ChainWriter& writer) {
    const std::string block = record::encode_block(std::vector<Record>(1U << 20U));
    for (int i = 0; i < 24; ++i) ASSERT_TRUE(writer.append("stream", 0, block));
  });
  expect_bounded({"audit bomb.dwell", "show bomb.dwell", "identify --method harmonic bomb.dwell",
                  "identify --method motion bomb.dwell", "replay bomb.dwell", "report bomb.dwell -o bomb.html"});
}

// It is intact, but not as dwelld writes it: the report holds what can be read, and names the rest.
TEST_F(HostileFile, OfWhichAPartCannotBeReadIsReportedWithTheRest) {
  const auto fill = [](record::ChainWriter& writer) {
    const Record good{.t_ns = 1'000'000, .value = 5.0, .channel = 0}, bad{.t_ns = 2'000'000, .channel = 65535};
    ASSERT_TRUE(writer.append("stream", 2'000'000, record::encode_block(std::vector<Record>{good, bad})));
    ASSERT_TRUE(writer.append("result", 2'000'000, to_json(record::StoredResult{1, true, "{}"})));
    const record::StoredEvent event{1, "2026-11-23T03:12:18Z", "action", "knocked", {}, "", "", ""};
    ASSERT_TRUE(writer.append("event", 2'000'000, to_json(event)));
  };
  const auto code_of = [this](const std::string& verb) {
    const std::string command = "cd " + scratch_.path() + " && " DWELLCTL " " + verb + " >said.out 2>said.err";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  };
  const auto expect_all = [this](const std::string& file, const std::vector<std::string>& parts) {
    const std::string text = record::Scratch::read(scratch_.path(file));
    for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << file << ": " << part;
  };
  make(fill);
  EXPECT_EQ(code_of("audit bomb.dwell"), 0);
  EXPECT_EQ(code_of("report bomb.dwell -o page.html"), 2);
  const std::vector<std::string> why{"a sample of channel 65535; the rig has 3",
                                     "the result at position 1: dwell object: index: expected to be there"};
  expect_all("said.err", why);
  expect_all("page.html", {"Parts of the file cannot be read", why[0], why[1], "knocked", "Rig: mount"});

  std::filesystem::remove(scratch_.path("bomb.dwell"));
  std::filesystem::remove(scratch_.path("honest.dwell"));
  make(fill, [](record::RunHeader& header) { header.rig.text = "# nothing"; });
  EXPECT_EQ(code_of("report bomb.dwell -o page.html --overwrite --json"), 2);
  EXPECT_EQ(test::ApiSchema().faults_of_text("report", record::Scratch::read(scratch_.path("said.out"))), "");
  expect_all("page.html", {"the rig file in it cannot be read: ", "a rig whose file cannot be used", "<td>y0</td>",
                           "Without a usable rig file: the devices&#39; own numbers", "knocked"});
}

TEST_F(HostileFile, OfEventsOfSevenMegabytesIsCutAndSaysSo) {
  if (kUnderSanitizer) GTEST_SKIP() << "a sanitizer takes address space of its own";
  make([](record::ChainWriter& writer) {
    record::StoredEvent event{1, "2026-11-23T03:12:18Z", "action", std::string(7'000'000, 'x'), {}, "", "", ""};
    for (int i = 0; i < 40; ++i) ASSERT_TRUE(writer.append("event", 0, to_json(event)));
  });
  expect_bounded({"audit bomb.dwell", "show bomb.dwell", "show bomb.dwell --json", "report bomb.dwell -o bomb.html"});
  const std::string page = record::Scratch::read(scratch_.path("bomb.html"));
  EXPECT_LT(page.size(), 1'000'000U);
  EXPECT_NE(page.find("xx … (cut: 6998000 bytes more, which are in the run file)"), std::string::npos);
}

}  // namespace
}  // namespace dwell
