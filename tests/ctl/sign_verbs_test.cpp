// keygen and sign, as their users see them.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/ctl/program.hpp"
#include "tests/ctl/recorded_runs.hpp"
#include "tests/ctl/scripted_server.hpp"

namespace dwell {
namespace {

using record::SampleRun;
using test::holds, test::Outcome;

using SignVerbs = test::RecordedRuns;

TEST_F(SignVerbs, APersonSignsWithAKeyOfTheirOwn) {
  const std::string run = written("run.dwell");
  const std::string own = folder.path("config/key");
  const Outcome made = test::run({"keygen", "--key", own, "--name", "anna@desk"});
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string vkey = test::contents(own + ".pub");
  EXPECT_TRUE(holds(made.out, vkey)) << made.out;
  struct stat is {};
  ASSERT_EQ(stat(own.c_str(), &is), 0);
  EXPECT_EQ(is.st_mode & 0777u, 0600u);
  EXPECT_EQ(test::run({"keygen", "--key", own}).code, 2);  // never replaces one

  const Outcome outcome = test::run({"sign", run, "--meaning", "reviewed", "--name", "Anna Weber", "--reason",
                                     "for the certificate", "--key", own, "--control", folder.path("none")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "  not in the ledger: ")) << outcome.out;
  EXPECT_TRUE(holds(outcome.out, "dwellctl sign --enter enters it")) << outcome.out;
  EXPECT_TRUE(holds(outcome.out, "Anna Weber: reviewed")) << outcome.out;
  EXPECT_TRUE(holds(outcome.out, "with the key anna@desk ")) << outcome.out;

  const Outcome audit = test::run({"audit", run, "--key", key.public_key().vkey()});
  EXPECT_EQ(audit.code, 0) << audit.out;
  EXPECT_TRUE(holds(audit.out, ": intact\n  signed: ")) << audit.out;
  EXPECT_TRUE(holds(audit.out, "Anna Weber")) << audit.out;
  EXPECT_TRUE(holds(audit.out, ", not trusted: Anna Weber: reviewed")) << audit.out;
  const std::string persons = folder.file("persons", "# who may sign\n\n" + vkey);
  for (const std::string& known : {own + ".pub", persons, vkey.substr(0, vkey.find('\n'))}) {
    const Outcome pinned = test::run({"audit", run, "--person", known});
    EXPECT_EQ(pinned.code, 0) << pinned.err;
    EXPECT_TRUE(holds(pinned.out, "with the pinned key anna@desk ")) << pinned.out;
    EXPECT_TRUE(holds(pinned.out, "intact, key ")) << "the service's key is not pinned by it: " << pinned.out;
    const auto json = nlohmann::json::parse(test::run({"audit", run, "--json", "--person", known}).out);
    EXPECT_EQ(json["files"][0]["signature_keys"][0]["trusted"], true);
  }
  EXPECT_EQ(test::run({"audit", run, "--person", folder.file("empty", "# nobody\n")}).code, 2);
  const Outcome show = test::run({"show", run});
  EXPECT_TRUE(holds(show.out, "signatures\n  with the key anna@desk ")) << show.out;
  EXPECT_TRUE(holds(show.out, "certificate")) << show.out;
}

TEST_F(SignVerbs, ASignatureByAnOwnKeyIsEnteredIntoTheLedgerOfTheServiceAtHand) {
  const std::string run = written("run.dwell"), own = folder.path("key"), control = folder.path("control");
  ASSERT_EQ(test::run({"keygen", "--key", own}).code, 0);
  test::ScriptedServer server(
      {{"{\"run\":17,\"entered\":1}\n"}, {"{\"run\":17,\"entered\":0}\n"}, {"{\"error\":\"run.dwell is tampered\"}\n"}},
      control);
  const Outcome signed_by_own =
      test::run({"sign", run, "--meaning", "reviewed", "--name", "A", "--key", own, "--control", control});
  EXPECT_EQ(signed_by_own.code, 0) << signed_by_own.err;
  EXPECT_TRUE(holds(signed_by_own.out, "\n  the ledger knows it\n")) << signed_by_own.out;
  const auto request = nlohmann::json::parse(server.requests().at(0));
  EXPECT_EQ(request["verb"], "enter");
  EXPECT_EQ(request["file"], std::filesystem::absolute(run).string());
  const Outcome again = test::run({"sign", run, "--enter", "--control", control});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_TRUE(holds(again.out, "the ledger knows all its signatures")) << again.out;
  const Outcome refused = test::run({"sign", run, "--enter", "--control", control});
  EXPECT_EQ(refused.code, 1);
  EXPECT_TRUE(holds(refused.err, "run.dwell is tampered")) << refused.err;
  EXPECT_EQ(test::run({"sign", run}).code, 2) << "neither --meaning nor --enter";
  EXPECT_EQ(test::run({"sign", run, "--enter", "--control", folder.path("none")}).code, 3);
}

TEST_F(SignVerbs, WordsThatAreNotUtf8AreRefusedAndTheFileStaysAsItWas) {
  const std::string run = written("run.dwell"), own = folder.path("key"),
                    bad =
                        "gepr\xfc"
                        "ft";
  ASSERT_EQ(test::run({"keygen", "--key", own}).code, 0);
  const std::string before = test::contents(run);
  for (const char* option : {"--meaning", "--name", "--reason"}) {
    std::vector<std::string> asked = {"sign", run, "--key", own, option, bad};
    if (option != std::string("--meaning")) asked.insert(asked.end(), {"--meaning", "reviewed"});
    const Outcome outcome = test::run(asked);
    EXPECT_EQ(outcome.code, 2) << option;
    EXPECT_TRUE(holds(outcome.err, option) && holds(outcome.err, "byte 5 is 0xFC, expected text in UTF-8"))
        << outcome.err;
  }
  EXPECT_EQ(test::contents(run), before);
  for (const std::vector<std::string>& asked :
       {std::vector<std::string>{"start", "--label", bad},
        {"start", "--label", "a", "--comment", bad},
        {"stop", "--comment", bad},
        {"rearm", "--comment", bad},
        {"replay", run, "--rig", "r.toml", "-o", "c.dwell", "--comment", bad}}) {
    const Outcome outcome = test::run(asked);
    EXPECT_EQ(outcome.code, 2) << asked.front();
    EXPECT_TRUE(holds(outcome.err, "byte 5 is 0xFC")) << outcome.err;
  }
}

// The same rule holds for every text that goes into the record. A refusal names the text, what is wrong and what is
// allowed.
TEST_F(SignVerbs, WordsThatCannotStandInTheRecordAreWrongUsage) {
  const std::string run = written("run.dwell"), own = folder.path("key");
  ASSERT_EQ(test::run({"keygen", "--key", own}).code, 0);
  const std::string before = test::contents(run);
  const auto refused = [](std::vector<std::string> asked, const std::string& option, const std::string& text,
                          const std::string& why) {
    asked.insert(asked.end(), {option, text});
    const Outcome outcome = test::run(asked);
    EXPECT_EQ(outcome.code, 2) << asked.front() << " " << option << ": " << outcome.out;
    EXPECT_TRUE(holds(outcome.err, option + ": " + why)) << outcome.err;
  };
  const std::vector<std::pair<std::vector<std::string>, std::string>> labels{
      {{"start"}, "--label"},
      {{"sign", run, "--key", own}, "--meaning"},
      {{"sign", run, "--key", own, "--meaning", "reviewed"}, "--name"}};
  const std::vector<std::pair<std::vector<std::string>, std::string>> comments{
      {{"start", "--label", "a"}, "--comment"},
      {{"stop"}, "--comment"},
      {{"replay", run, "--rig", "r.toml", "-o", "c.dwell"}, "--comment"},
      {{"sign", run, "--key", own, "--meaning", "reviewed"}, "--reason"}};
  for (const auto& [asked, option] : labels) {
    refused(asked, option, "   ", "it holds only spaces, expected words");
    refused(asked, option, std::string(201, 'a'), "it has 201 bytes, expected at most 200");
    refused(asked, option, std::string(100'000, 'a'), "it has 100000 bytes, expected at most 200");
  }
  for (const auto& [asked, option] : comments)
    refused(asked, option, std::string(4001, 'a'), "it has 4001 bytes, expected at most 4000");
  for (const auto* all : {&labels, &comments})
    for (const auto& [asked, option] : *all)
      for (const char* text : {"a\nb", "a\x1b[31m",
                               "a\xc2\x9b"
                               "b",
                               "a\xe2\x80\xae"
                               "b"})
        refused(asked, option, text, "it holds a control character, expected one line of plain text");
  refused({"start"}, "--label", "", "expected text");
  EXPECT_EQ(test::contents(run), before);
}

TEST_F(SignVerbs, APublicKeySignsNothingAndIsCalledWhatItIs) {
  const std::string run = written("run.dwell"), own = folder.path("key");
  ASSERT_EQ(test::run({"keygen", "--key", own}).code, 0);
  const Outcome outcome = test::run({"sign", run, "--meaning", "reviewed", "--name", "A", "--key", own + ".pub"});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_TRUE(holds(outcome.err, own + ".pub: is a public key; expected the private key")) << outcome.err;
  EXPECT_FALSE(holds(outcome.err, "keygen")) << outcome.err;
}

TEST_F(SignVerbs, WhereNoLogCanLieBesideTheFileTheReasonIsToldAndTheFileStaysAsItWas) {
  const std::string run = written("run.dwell"), own = folder.path("key");
  ASSERT_EQ(test::run({"keygen", "--key", own}).code, 0);
  std::filesystem::create_symlink("nowhere", run + "-wal");
  const std::string before = test::contents(run);
  const Outcome outcome = test::run({"sign", run, "--meaning", "reviewed", "--name", "A", "--key", own});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_TRUE(holds(outcome.err, run + "-wal: is no regular file")) << outcome.err;
  EXPECT_EQ(test::contents(run), before);
}

TEST_F(SignVerbs, WhatHasNotEndedIsNotSigned) {
  SampleRun run = make("open.dwell");
  run.closed = false;
  write(run, key);
  const std::string own = folder.path("key");
  ASSERT_EQ(test::run({"keygen", "--key", own}).code, 0);
  const std::string before = test::contents(run.path);
  const Outcome outcome = test::run({"sign", run.path, "--meaning", "reviewed", "--name", "A", "--key", own});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_TRUE(holds(outcome.err, "the run has no end")) << outcome.err;
  EXPECT_EQ(test::contents(run.path), before);
}

TEST_F(SignVerbs, SigningThroughAServiceThatIsNotThereSaysWhatElseCanBeDone) {
  const std::string run = written("run.dwell");
  const Outcome outcome = test::run({"sign", run, "--meaning", "reviewed", "--control", folder.path("none")});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_TRUE(holds(outcome.err, "--key FILE")) << outcome.err;
}

TEST_F(SignVerbs, SignThroughTheServiceSendsThePathInFullAndTellsWhoVouches) {
  const std::string control = folder.path("control");
  test::ScriptedServer server(
      {{R"({"run":17,"signature":{"name":"Anna Weber","meaning":"reviewed","utc":"2026-07-02T08:00:00Z","seq":9,"head":")" +
        std::string(64, 'a') +
        R"(","person":{"uid":1000,"name":"anna"}}})"
        "\n"},
       {"{\"error\":\"/var/lib/dwell/run.dwell: the run has not ended\"}\n"},
       {"{\"error\":\"/none.dwell: is not in the recording directory\"}\n"}},
      control);
  const std::string file = std::filesystem::relative(folder.file("run.dwell", "the service's")).string();
  const std::vector<std::string> command{"sign", file, "--meaning", "reviewed", "--control", control};
  const Outcome outcome = test::run(command);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, file +
                             ": signed: countersigned by the service for anna (uid 1000): Anna Weber: reviewed, "
                             "2026-07-02T08:00:00Z\n");
  const auto request = nlohmann::json::parse(server.requests().at(0));
  EXPECT_EQ(request["verb"], "sign");
  EXPECT_EQ(request["file"], std::filesystem::absolute(file).string());
  EXPECT_EQ(request["meaning"], "reviewed");
  const Outcome refused = test::run(command);
  EXPECT_EQ(refused.code, 1);
  EXPECT_TRUE(holds(refused.err, "has not ended")) << refused.err;
  const std::string none = folder.path("none.dwell");
  const Outcome missing = test::run({"sign", none, "--meaning", "reviewed", "--control", control});
  EXPECT_EQ(missing.code, 2);
  EXPECT_TRUE(holds(missing.err, none + ": No such file or directory")) << missing.err;
}

}  // namespace
}  // namespace dwell
