#include "daemon/run/countersigner.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <future>
#include <nlohmann/json.hpp>

#include "daemon/record/run_reader.hpp"
#include "daemon/record/signature.hpp"
#include "tests/record/audited.hpp"
#include "tests/record/sample_run.hpp"
#include "tests/record/scratch.hpp"

namespace dwell {
namespace {

// Asks and waits for the answer.
record::Result<Signed> answer_of(Countersigner& signer, const SignRequest& asked) {
  std::promise<record::Result<Signed>> answer;
  signer.ask(asked, [&answer](const record::Result<Signed>& made) { answer.set_value(made); });
  return answer.get_future().get();
}

struct CountersignerTest : testing::Test {
  record::SampleRun written(const std::string& name, bool closed = true) {
    record::SampleRun run = record::sample_run_file(scratch.path(name), key, R"({"index":1})");
    run.closed = closed;
    run.header.run = ledger.next_run();
    run.header.previous_head = ledger.newest_head();
    write(run, key);
    EXPECT_TRUE(ledger.run_begins(run.header, name));
    if (closed) {
      EXPECT_TRUE(ledger.run_ends({run.header.run, std::string(64, '7'), 1, "closed"}));
    }
    return run;
  }
  void begin() {
    ASSERT_TRUE(key.save(scratch.path("key")));
    signer.emplace(scratch.path(),
                   [this](std::int64_t, const record::PersonalSignature& signature) -> record::Result<void> {
                     if (ledger_fails) return tl::unexpected(std::string("disk full"));
                     entered.push_back(signature);
                     return {};
                   });
  }
  static SignRequest request(const std::string& file) {
    SignRequest request;
    request.file = file;
    request.statement.name = "Anna Weber";
    request.statement.meaning = "reviewed";
    request.uid = getuid();
    return request;
  }
  record::Result<Signed> sign(const SignRequest& asked) { return answer_of(*signer, asked); }

  const record::Scratch scratch;
  const record::SigningKey key = record::sample_key("bench2");
  record::Ledger ledger = *record::Ledger::open(scratch.path(), key);
  bool ledger_fails = false;
  std::vector<record::PersonalSignature> entered;
  std::optional<Countersigner> signer;
};

TEST_F(CountersignerTest, SignsAClosedRunForWhoAsksAndTheLedgerKnows) {
  const auto run = written("run.dwell");
  begin();
  for (const std::string& file : {run.path, std::string("run.dwell")}) {
    const auto made = sign(request(file));
    ASSERT_TRUE(made) << made.error();
    EXPECT_EQ(made->run, 1);
    ASSERT_TRUE(made->signature->person);
    EXPECT_EQ(made->signature->person->uid, getuid());
  }
  signer.reset();
  ASSERT_EQ(entered.size(), 2u);
  EXPECT_EQ(entered[0].name, "Anna Weber");
  EXPECT_LT(entered[0].seq, entered[1].seq);
  auto reader = record::RunReader::open(run.path);
  ASSERT_TRUE(reader) << reader.error();
  EXPECT_EQ(reader->signatures()->size(), 2u);
}

TEST_F(CountersignerTest, TakesTheNameOfTheSystemWhereNoneIsGiven) {
  (void)written("run.dwell");
  begin();
  SignRequest asked = request("run.dwell");
  asked.statement.name.clear();
  const auto made = sign(asked);
  ASSERT_TRUE(made) << made.error();
  EXPECT_NE(made->signature->name, "");
}

TEST_F(CountersignerTest, TouchesNothingButClosedRunsInItsDirectory) {
  namespace fs = std::filesystem;
  const record::Scratch elsewhere;
  record::SampleRun other = record::sample_run_file(elsewhere.path("other.dwell"), key, "{}");
  write(other, key);
  const std::string open = written("open.dwell", false).path;
  const std::string link = scratch.path("link.dwell");
  fs::create_symlink(other.path, link);
  fs::create_directory(scratch.path("folder.dwell"));
  fs::create_directory_symlink(elsewhere.path(), scratch.path("out"));
  const std::string before = record::Scratch::read(other.path) + record::Scratch::read(open);
  begin();
  for (const std::string& file :
       {other.path, open, link, scratch.path("folder.dwell"), scratch.path("out/other.dwell"),
        scratch.path("../" + fs::path(elsewhere.path()).filename().string() + "/other.dwell"),
        scratch.path("none.dwell"), scratch.path("key"), std::string(".."), std::string(1, '\0')}) {
    const auto made = sign(request(file));
    ASSERT_FALSE(made) << file;
    EXPECT_NE(made.error(), "") << file;
  }
  signer.reset();
  EXPECT_TRUE(entered.empty());
  EXPECT_EQ(record::Scratch::read(other.path) + record::Scratch::read(open), before);
}

TEST_F(CountersignerTest, SaysWhereTheLedgerCouldNotBeTold) {
  (void)written("run.dwell");
  ledger_fails = true;
  begin();
  const auto made = sign(request("run.dwell"));
  ASSERT_FALSE(made);
  EXPECT_NE(made.error().find("the ledger does not know of it: disk full"), std::string::npos) << made.error();
}

TEST_F(CountersignerTest, AnswersEveryoneWhenItGoes) {
  (void)written("run.dwell");
  begin();
  std::atomic<int> answers = 0;
  for (int i = 0; i < 40; ++i)
    signer->ask(request("run.dwell"), [&answers](const record::Result<Signed>&) { ++answers; });
  signer.reset();
  EXPECT_EQ(answers, 40);
}

// The ledger of a directory with one run, the service's key, and a person's own key under the run.
struct OwnKeySignatures : testing::Test {
  static record::PersonalSignature words(const std::string& meaning) {
    record::PersonalSignature words = record::sample_words();
    words.meaning = meaning;
    return words;
  }
  record::Result<Signed> enter() { return answer(run, true); }
  // To a request to enter the signatures under this file, or to sign it.
  record::Result<Signed> answer(const std::string& file, bool enter) {
    Countersigner signer(scratch.path(), [this](std::int64_t number, const record::PersonalSignature& signature) {
      return ledger.run_signed(number, signature);
    });
    SignRequest request;
    request.file = file;
    request.enter = enter;
    request.statement = words("reviewed");
    request.uid = getuid();
    return answer_of(signer, request);
  }
  // By the ledger and the pinned key.
  [[nodiscard]] record::Audit audited() const {
    record::AuditOptions options = record::with_ledger(scratch);
    options.keys = {record::sample_key().public_key()};
    return record::audited(run, options);
  }

  const record::Scratch scratch{true};
  record::Ledger ledger = record::recorded(scratch, 1);
  const std::string run = scratch.path("a.dwell");
  const record::SigningKey own = record::sample_key("anna@desk");
};

TEST_F(OwnKeySignatures, AreEntriesOfTheLedgerOnce) {
  const std::string before = record::Scratch::read(run);
  ASSERT_TRUE(sign_by_own_key(run, words("reviewed"), own));
  ASSERT_TRUE(sign_by_own_key(run, words("released"), own));
  const auto first = enter(), again = enter();
  ASSERT_TRUE(first) << first.error();
  EXPECT_EQ(first->run, 1);
  EXPECT_EQ(first->entered, 2u);
  EXPECT_FALSE(first->signature);
  ASSERT_TRUE(again) << again.error();
  EXPECT_EQ(again->entered, 0u);
  EXPECT_EQ(audited().state, record::AuditState::intact) << audited().where;
  scratch.write("a.dwell", before);
  EXPECT_NE(audited().where.find("the signature of Anna"), std::string::npos) << "taken away: " << audited().where;
}

TEST_F(OwnKeySignatures, UnderAFileThatIsNotTheLedgersRunAreNotEntered) {
  record::RunHeader another = record::sample_header(1, record::sample_key());
  another.id = std::string(32, '7');
  std::filesystem::remove(run);
  record::write_sample(run, {.seed = 9, .header = another});
  ASSERT_TRUE(sign_by_own_key(run, words("reviewed"), own));
  const auto done = enter();
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().find("the ledger knows another run as run 1"), std::string::npos) << done.error();
}

// A signature under a copy would be missing in the run's own file for ever.
TEST_F(OwnKeySignatures, UnderACopyByAnotherNameAreNotEntered) {
  std::filesystem::copy_file(run, scratch.path("copy.dwell"));
  ASSERT_TRUE(sign_by_own_key(scratch.path("copy.dwell"), words("reviewed"), own));
  const auto done = answer("copy.dwell", true);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().find("copy.dwell: is a copy of run 1, whose file is a.dwell in the ledger"), std::string::npos)
      << done.error();
  EXPECT_EQ(audited().state, record::AuditState::intact) << audited().where;
}

TEST_F(OwnKeySignatures, NorDoesTheServiceSignSuchACopy) {
  ASSERT_TRUE(record::sample_key().save(scratch.path("key")));
  std::filesystem::copy_file(run, scratch.path("copy.dwell"));
  const std::string before = record::Scratch::read(run);
  const auto done = answer("copy.dwell", false);
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().find("copy.dwell: is a copy of run 1, whose file is a.dwell in the ledger"), std::string::npos)
      << done.error();
  EXPECT_EQ(record::Scratch::read(scratch.path("copy.dwell")), before);
  EXPECT_EQ(audited().state, record::AuditState::intact) << audited().where;
  EXPECT_TRUE(answer("a.dwell", false));
}

TEST_F(OwnKeySignatures, UnderAChildFileAreInNoLedger) {
  record::RunHeader child = record::sample_header(0, record::sample_key());
  child.parent_id = std::string(32, '7');
  std::filesystem::remove(run);
  record::write_sample(run, {.seed = 9, .header = child});
  ASSERT_TRUE(sign_by_own_key(run, words("reviewed"), own));
  const auto done = enter();
  ASSERT_FALSE(done);
  EXPECT_NE(done.error().find("is a child file, which no ledger knows"), std::string::npos) << done.error();
}

TEST(SignRequest, ToEnterSignaturesNeedsNoMeaning) {
  const auto asked = parse_sign_request(R"({"verb":"enter","file":"a.dwell"})", 7);
  ASSERT_TRUE(asked && *asked);
  EXPECT_TRUE((*asked)->enter);
  EXPECT_EQ(sign_answer(Signed{3, std::nullopt, 2}), R"({"run":3,"entered":2})");
}

TEST(SignRequest, NamesWhatIsMissingInALine) {
  const auto why = [](const std::string& members) {
    return parse_sign_request(R"({"verb":"sign")" + members + "}", 0)->error();
  };
  EXPECT_EQ(why(""), "no file: expected the path of a run file");
  EXPECT_EQ(why(R"(,"file":3)"), "file: expected a text");
  EXPECT_EQ(why(R"(,"file":"a.dwell")"), "no meaning: expected for instance \"reviewed\"");
  const auto asked = parse_sign_request(R"({"verb":"sign","file":"a.dwell","meaning":"seen","reason":null})", 7);
  ASSERT_TRUE(asked && *asked);
  EXPECT_EQ((*asked)->uid, 7u);
  EXPECT_EQ((*asked)->statement.meaning, "seen");
}

TEST(SignRequest, LeavesOtherLinesToOthers) {
  for (const std::string& line : {std::string("x"), std::string(R"({"verb":"status"})"), std::string(R"({"verb":3})"),
                                  std::string(40'000, '['), std::string()})
    EXPECT_FALSE(parse_sign_request(line, 0)) << line.substr(0, 40);
}

TEST(SignRequest, IsAnsweredWithTheSignatureOrTheReason) {
  EXPECT_EQ(sign_answer(tl::unexpected(std::string("no"))), R"({"error":"no"})");
  record::PersonalSignature signature;
  signature.name = "Anna";
  const auto json = nlohmann::json::parse(sign_answer(Signed{3, signature, 1}));
  EXPECT_EQ(json["run"], 3);
  EXPECT_EQ(json["signature"]["name"], "Anna");
}

}  // namespace
}  // namespace dwell
