// The verbs that look at run files, as their users see them.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "daemon/ctl/run_summary.hpp"
#include "daemon/record/ledger.hpp"
#include "daemon/record/utc_text.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/number_text.hpp"
#include "tests/api_schema.hpp"
#include "tests/ctl/program.hpp"
#include "tests/ctl/recorded_runs.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/ctl/scripted_server.hpp"
#include "tests/ctl/temporary.hpp"
#include "tests/record/sample_run.hpp"

namespace dwell {
namespace {

using record::SampleRun;
using test::holds;
using test::Outcome;

using RecordVerbs = test::RecordedRuns;

TEST_F(RecordVerbs, AuditSaysIntactAndWhetherTheKeyIsTheOneAskedFor) {
  const std::string run = written("run.dwell");
  const std::string fingerprint = key.public_key().fingerprint();
  const Outcome unknown = test::run({"audit", run});
  EXPECT_EQ(unknown.code, 0) << unknown.err;
  EXPECT_EQ(unknown.out, run + ": intact, key " + fingerprint + " not trusted\n");
  const std::string vkey = key.public_key().vkey();
  for (const std::string& pinned : {vkey, folder.file("key.pub", vkey + "\n")}) {
    const Outcome known = test::run({"audit", run, "--key", pinned});
    EXPECT_EQ(known.code, 0) << known.err;
    EXPECT_EQ(known.out, run + ": intact\n");
  }
}

TEST_F(RecordVerbs, AuditSaysWhereAFileIsTamperedWithAndGoesOnWithTheOthers) {
  const std::string bad = written("bad.dwell");
  alter(bad, "UPDATE entry SET t_ns = t_ns + 1 WHERE seq = 4");
  const std::string good = written("good.dwell");
  const Outcome outcome = test::run({"audit", bad, good, "--key", key.public_key().vkey()});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_TRUE(holds(outcome.out, bad + ": tampered: ")) << outcome.out;
  EXPECT_TRUE(holds(outcome.out, "4")) << outcome.out;
  EXPECT_TRUE(holds(outcome.out, good + ": intact\n")) << outcome.out;
}

TEST_F(RecordVerbs, AuditSaysUntilWhenAnOpenFileHolds) {
  SampleRun run = make("open.dwell");
  run.closed = false;
  write(run, key);
  const Outcome outcome = test::run({"audit", run.path, "--key", key.public_key().vkey()});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out.rfind(run.path + ": open until ", 0), 0u) << outcome.out;
}

TEST_F(RecordVerbs, AuditCountsAFileWithoutAnEndAsAFailureWhereItIsAskedTo) {
  SampleRun run = make("open.dwell");
  run.closed = false;
  write(run, key);
  const Outcome outcome = test::run({"audit", run.path});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, ": it has no end (crashed, running, or cut off)")) << outcome.out;
  EXPECT_EQ(test::run({"audit", "--closed", run.path}).code, 1);
  EXPECT_EQ(test::run({"audit", "--closed", written("run.dwell")}).code, 0);
}

// `audit DIR/*` finds them beside the runs.
TEST_F(RecordVerbs, AuditSaysOfFilesBesideTheRunsWhatTheyAre) {
  const std::string good = written("good.dwell"), bad = written("bad.dwell");
  alter(bad, "UPDATE entry SET t_ns = t_ns + 1 WHERE seq = 4");
  const std::string ledger = folder.path("ledger.dwell-ledger");
  auto made = record::Ledger::open(folder.path(""), key);
  ASSERT_TRUE(made && made->merge_log());
  const std::string reserve = folder.file("reserve", std::string(1000, '\0'));
  for (const auto& [file, words] : {std::pair(ledger, "is a ledger, no run file; `dwellctl audit --ledger` takes it"),
                                    std::pair(ledger + "-wal", "is the -wal of a run or a ledger"),
                                    std::pair(reserve, "is the room that the service reserves")}) {
    const Outcome outcome = test::run({"audit", good, file});
    EXPECT_EQ(outcome.code, 2) << file;
    EXPECT_TRUE(holds(outcome.err, words)) << outcome.err << outcome.out;
    EXPECT_FALSE(holds(outcome.out, "tampered")) << outcome.out;
    EXPECT_EQ(test::run({"audit", bad, file}).code, 1) << "what is tampered with decides";
  }
  std::filesystem::copy_file(ledger, folder.path("run.dwell"));
  EXPECT_EQ(test::run({"audit", folder.path("run.dwell")}).code, 1) << "in a run's place it is none";
}

TEST_F(RecordVerbs, AuditAsJsonIsAsTheInterfaceSays) {
  const std::string bad = written("bad.dwell");
  alter(bad, "DELETE FROM entry WHERE seq = 4");
  const std::string good = written("good.dwell");
  const Outcome outcome = test::run({"audit", "--json", good, bad});
  EXPECT_EQ(outcome.code, 1);
  const auto json = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(json["files"].size(), 2u);
  const auto& intact = json["files"][0];
  EXPECT_EQ(intact["file"], good);
  EXPECT_EQ(intact["state"], "intact");
  EXPECT_EQ(intact["run"], 17);
  EXPECT_EQ(intact["samples"], 4000);
  EXPECT_EQ(intact["head"].get<std::string>().size(), 64u);
  EXPECT_TRUE(intact["where"].is_null());
  EXPECT_TRUE(intact["until_s"].is_null());
  EXPECT_EQ(intact["trusted"], false);
  EXPECT_EQ(json["files"][1]["state"], "tampered");
  EXPECT_TRUE(json["files"][1]["where"].is_string());
  EXPECT_TRUE(json["ledger"].is_null());
}

TEST_F(RecordVerbs, AuditWithTheLedgerMissesARunThatWasRemoved) {
  const SampleRun run = make("run.dwell");
  write(run, key);
  const std::string ledger = folder.path("ledger.dwell-ledger");
  record::Anchor anchor;
  {
    auto made = record::Ledger::open(folder.path(""), key);
    ASSERT_TRUE(made) << made.error();
    record::RunHeader first = run.header;
    first.run = made->next_run();
    ASSERT_TRUE(made->run_begins(first, "run.dwell"));
    anchor = made->head();
    anchor.utc = "2026-11-23T03:12:17.250000Z";
  }
  const Outcome there = test::run({"audit", "--ledger", ledger, "--key", key.public_key().vkey()});
  EXPECT_EQ(there.code, 0) << there.out << there.err;
  EXPECT_TRUE(holds(there.out, ledger + ": unbroken\n")) << there.out;
  const std::vector<std::string> of_run{"audit", folder.path("run.dwell"), "--key", key.public_key().vkey(),
                                        "--ledger"};
  std::vector<std::string> named_too = of_run;
  named_too.push_back(ledger);
  const Outcome beside = test::run(of_run), named = test::run(named_too);
  EXPECT_TRUE(holds(named.out, ledger + ": unbroken\n")) << named.out;
  EXPECT_EQ(beside.out, named.out) << "without a name it is the one beside the files";
  EXPECT_EQ(beside.code, named.code);
  const test::TemporaryFolder elsewhere;
  for (const std::vector<std::string>& unclear :
       {std::vector<std::string>{"audit", "--ledger"},
        {"audit", folder.path("run.dwell"), elsewhere.path("run.dwell"), "--ledger"}}) {
    const Outcome asked = test::run(unclear);
    EXPECT_EQ(asked.code, 2) << asked.out;
    EXPECT_TRUE(holds(asked.err, "--ledger: expected the name of a ledger")) << asked.err;
  }
  std::filesystem::create_symlink(ledger, elsewhere.path("link"));
  const Outcome linked = test::run({"audit", "--ledger", elsewhere.path("link"), "--key", key.public_key().vkey()});
  EXPECT_EQ(linked.code, 0) << "the runs lie beside the ledger itself: " << linked.out;
  const Outcome alone = test::run({"audit", "--ledger", ledger});
  EXPECT_EQ(alone.out, ledger + ": unbroken, key " + key.public_key().fingerprint() + " not trusted\n");
  const Outcome held =
      test::run({"audit", "--ledger", ledger, "--anchor", folder.file("kept", to_line(anchor) + "\n")});
  EXPECT_TRUE(holds(held.out, "\n  anchors: 1 head of this ledger was compared, and holds\n")) << held.out;
  const std::string line =
      "2026-11-23T03:12:17.250000Z dwell/ledger/" + std::string(32, 'e') + " 2 " + std::string(43, 'A') + "=\n";
  const std::string anchors = folder.file("anchors", line + line + "run stopped by anna (uid 1000): " + line);
  const Outcome foreign = test::run({"audit", "--ledger", ledger, "--anchor", anchors});
  EXPECT_EQ(foreign.code, 0) << foreign.err;
  EXPECT_TRUE(holds(foreign.out, "\n  anchors: none of this ledger, so nothing was compared\n")) << foreign.out;
  EXPECT_TRUE(holds(foreign.out, "\n  anchors: 2 lines are of another ledger, so nothing was compared with them\n"))
      << foreign.out;
  const std::string skipped =
      "\nanchors: 1 line names a run or a ledger and does not have the form of an anchor: it was skipped\n";
  EXPECT_TRUE(holds("\n" + foreign.out, skipped)) << foreign.out;
  const Outcome run_alone = test::run({"audit", folder.path("run.dwell"), "--anchor", anchors});
  EXPECT_TRUE(holds(run_alone.out, skipped)) << "a lost anchor must not pass for none: " << run_alone.out;
  EXPECT_TRUE(holds(run_alone.out, "\n  anchors: none of this run, so nothing was compared\n")) << run_alone.out;
  EXPECT_EQ(nlohmann::json::parse(
                test::run({"audit", "--json", "--ledger", ledger, "--anchor", anchors}).out)["foreign_anchors"],
            2);
  std::filesystem::remove(run.path);
  const Outcome gone = test::run({"audit", "--ledger", ledger, "--key", key.public_key().vkey()});
  EXPECT_EQ(gone.code, 1);
  EXPECT_TRUE(holds(gone.out, "missing: ")) << gone.out;
  const auto json = nlohmann::json::parse(test::run({"audit", "--json", "--ledger", ledger}).out);
  EXPECT_EQ(json["ledger"].get<std::string>().rfind("missing: ", 0), 0u) << json;
}

TEST_F(RecordVerbs, UnusableInputIsOneLineAndExitCode2) {
  const std::string run = written("run.dwell");
  const std::string text = folder.file("text.dwell", "not a database");
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{"audit"},
                                                {"audit", folder.path("none.dwell")},
                                                {"audit", run, "--key", "nonsense"},
                                                {"audit", run, "--key", "a+b+c"},
                                                {"show"},
                                                {"show", folder.path("none.dwell")},
                                                {"show", text},
                                                {"runs", folder.path("none")},
                                                {"runs", ""},
                                                {"sign", run},
                                                {"identify", folder.path("none.dwell")},
                                                {"verify", folder.path("none.dwell")},
                                                {"sign", run, "--meaning", "reviewed", "--key", folder.path("none")}}) {
    const Outcome outcome = test::run(wrong);
    EXPECT_EQ(outcome.code, 2) << wrong[0] << ": " << outcome.out << outcome.err;
    EXPECT_NE(outcome.err, "") << wrong[0];
    EXPECT_EQ(outcome.out, "") << wrong[0];
  }
  EXPECT_EQ(test::run({"audit", text}).code, 1);  // tampered: it claims to be a run
}

TEST_F(RecordVerbs, ShowTellsWhatTheRunWas) {
  const std::string run = written("run.dwell");
  const Outcome outcome = test::run({"show", run});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* part : {"run 17 · mount A, 4 Hz · closed", "rig.toml", "anna (uid 1000)", "after the new bearing",
                           "on bench2 (Europe/Berlin), clock synchronized within", "4000 samples", "y0, reaction",
                           "dwell 1 · measuring", "stiffness", "kN/m", "3 samples of reaction came too late", "knocked",
                           "ended      2026-07-01T10:12:20.000000Z: operator"})
    EXPECT_TRUE(holds(outcome.out, part)) << part << "\n" << outcome.out;
}

// The entry `end` is written after the stream's end, and after the next run's begin if that follows at once.
TEST_F(RecordVerbs, ARunEndsWhereItsStreamDoesInEveryView) {
  SampleRun run = make("run.dwell");
  run.header.start_utc = "2026-07-01T10:11:58Z";
  write(run, key);
  const auto shown = nlohmann::json::parse(test::run({"show", "--json", run.path}).out);
  const auto listed = nlohmann::json::parse(test::run({"runs", "--json", folder.path("")}).out)["runs"][0];
  const std::string ended = listed["ended"].get<std::string>();
  EXPECT_EQ(shown["ended"], ended);
  EXPECT_EQ(shown["end"]["utc"], "2026-07-01T10:12:20Z") << "the entry as it is";
  const auto begun_ns = record::parse_utc(run.header.start_utc), ended_ns = record::parse_utc(ended);
  ASSERT_TRUE(begun_ns && ended_ns) << ended;
  EXPECT_NEAR(1e-9 * static_cast<double>(*ended_ns - *begun_ns), shown["span_s"].get<double>(), 2e-6) << "as printed";
  EXPECT_TRUE(holds(test::run({"show", run.path}).out, "ended      " + ended + ": operator"));
}

TEST_F(RecordVerbs, ShowSaysWhereTheClocksStateIsNotKnown) {
  SampleRun run = make("run.dwell");
  run.header.origin.clock_synchronized = false;
  run.header.origin.clock_error_s = std::nan("");
  write(run, key);
  const Outcome outcome = test::run({"show", run.path});
  EXPECT_TRUE(holds(outcome.out, "clock in an unknown state")) << outcome.out;
  EXPECT_FALSE(holds(outcome.out, "not synchronized")) << outcome.out;
}

TEST_F(RecordVerbs, ShowNamesTheFilesWithTheirSumsAndThoseWhoseTextIsNotKept) {
  SampleRun run = make("run.dwell");
  run.header.files = {{"motor.dbc", std::string(64, 'a'), "VERSION"}, {"tape.csv", std::string(64, 'b'), {}}};
  write(run, key);
  const std::string page = test::run({"show", run.path}).out;
  EXPECT_TRUE(holds(page, "with       motor.dbc\nSHA-256    " + std::string(64, 'a') + "\n")) << page;
  EXPECT_TRUE(
      holds(page, "with       tape.csv; its text is not in the run file\nSHA-256    " + std::string(64, 'b') + "\n"))
      << page;
}

TEST_F(RecordVerbs, ShowLinesUpIn80Columns) {
  SampleRun run = make("a-name-that-is-rather-long-for-a-file-but-which-somebody-will-give-it-some-day.dwell");
  run.header.label = std::string(200, 'l');
  run.events[0].text =
      "a reason that goes on and on, since whoever wrote it wished to leave no doubt about what it was";
  write(run, key);
  std::istringstream lines(test::run({"show", run.path}).out);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) EXPECT_LE(width(line), 80u) << line;
  EXPECT_GT(count, 20);
}

TEST_F(RecordVerbs, ShowBeginsALongPathBesideItsLabel) {
  SampleRun run = make(std::string(60, 'p') + ".dwell");
  run.events.push_back({100, "2026-07-01T10:12:10.250000Z", "fault", "device amplifier: crc, 1 times", {}, "", "", ""});
  write(run, key);
  const std::string page = test::run({"show", run.path}).out;
  EXPECT_TRUE(holds(page, "\nfile       " + run.path.substr(0, 60))) << page;
  EXPECT_FALSE(holds(page, "\n           , ")) << page;
  EXPECT_TRUE(holds(page, "\nsize       ")) << page;
  EXPECT_TRUE(holds(page, "device amplifier: crc, once\n")) << page;
}

TEST_F(RecordVerbs, JsonIsAsTheSchemaSays) {
  const test::ApiSchema schema;
  SampleRun open = make("open.dwell");
  open.closed = false;
  open.header.parent_id = std::string(32, '1');
  open.header.parent_head = std::string(64, '2');
  open.header.begun_by = "replay";
  open.header.person.reset();
  open.header.rig.text = "\xff not UTF-8";
  open.header.files = {{"motor.dbc", std::string(64, 'b'), "VERSION"}};
  open.header.origin.clock_error_s = kNaN;
  open.results.clear();
  write(open, key);
  const std::string run = written("run.dwell"), bad = written("bad.dwell");
  const std::string own = folder.path("own-key"), ledger = folder.path("ledger.dwell-ledger");
  ASSERT_EQ(test::run({"keygen", "--key", own}).code, 0);
  ASSERT_EQ(test::run({"sign", run, "--meaning", "reviewed", "--reason", "why", "--key", own}).code, 0);
  alter(bad, "DELETE FROM entry WHERE seq = 4");
  {
    auto made = record::Ledger::open(folder.path(""), key);
    ASSERT_TRUE(made) << made.error();
    record::RunHeader gone = open.header;
    gone.run = made->next_run();
    ASSERT_TRUE(made->run_begins(gone, "gone.dwell"));
  }
  EXPECT_EQ(schema.faults_of_text("audit", test::run({"audit", "--json", run, open.path, bad}).out), "");
  EXPECT_EQ(schema.faults_of_text("audit", test::run({"audit", "--json", "--ledger", ledger}).out), "");
  EXPECT_EQ(schema.faults_of_text("shown_run", test::run({"show", "--json", run}).out), "");
  EXPECT_EQ(schema.faults_of_text("shown_run", test::run({"show", "--json", open.path}).out), "");
  EXPECT_EQ(schema.faults_of_text("folder_runs", test::run({"runs", "--json", folder.path("")}).out), "");
}

TEST_F(RecordVerbs, ShowTellsOfAFaultThatLastsOnceWithItsSum) {
  SampleRun run = make("run.dwell");
  for (int second = 10; second < 50; ++second) {
    const std::string utc = "2026-07-01T10:12:" + std::to_string(second) + ".250000Z";
    run.events.push_back({100, utc, "fault", "device amplifier: timeout, 3 times", {}, "", "", ""});
    run.events.push_back({100, utc, "fault", "device amplifier: crc, 1 times", {}, "", "", ""});
    run.events.push_back({101, utc, "fault", "channel y0 does not deliver: timeout", {}, "", "", ""});
    run.events.push_back({102, utc, "loss", "channel y0: 5 samples lost, no room on their way", {}, "", "", ""});
  }
  run.events.push_back({5000, "2026-07-01T10:12:51.000000Z", "action", "rearm", {}, "", "", "the last"});
  write(run, key);
  const std::string out = test::run({"show", run.path}).out;
  for (const char* part : {"10:12:10.250  fault   device amplifier: timeout, 120 times, up to 10:12:49.250",
                           "device amplifier: crc, 40 times, up to 10:12:49.250", "rearm: the last",
                           "channel y0 does not deliver: timeout, 40 times, up to",
                           "10:12:10.250  channel y0: 200 samples lost, no room on their way, up to"})
    EXPECT_TRUE(holds(out, part)) << part << "\n" << out;
  EXPECT_FALSE(holds(out, "which --json shows")) << out;
  EXPECT_EQ(nlohmann::json::parse(test::run({"show", "--json", run.path}).out)["events"].size(), 3u + 161u);
}

TEST_F(RecordVerbs, ShowNamesAnEntryThatCannotBeReadAndShowsTheRest) {
  const test::ApiSchema schema;
  SampleRun run = make("run.dwell");
  run.results.push_back({200, true, "{}"});
  write(run, key);
  const Outcome page = test::run({"show", run.path});
  EXPECT_EQ(page.code, 2);
  const std::string why = run.path + ": the result at position 200: dwell object: index: expected to be there";
  EXPECT_EQ(page.err, "dwellctl: " + why + "\n");
  for (const char* part :
       {"cannot be read; the rest stands below", "the result at position 200", "dwell 1 · ", "knocked"})
    EXPECT_TRUE(holds(page.out, part)) << part << "\n" << page.out;
  const Outcome json = test::run({"show", "--json", run.path});
  EXPECT_EQ(json.code, 2);
  EXPECT_EQ(schema.faults_of_text("shown_run", json.out), "");
  const auto shown = nlohmann::json::parse(json.out);
  EXPECT_EQ(shown["unreadable"], nlohmann::json::array({why}));
  EXPECT_EQ(shown["dwells"].size(), 1u);
  EXPECT_EQ(shown["events"].size(), 3u);
}

TEST_F(RecordVerbs, ShowCountsTheEntriesBeyondWhatItKeeps) {
  const test::ApiSchema schema;
  SampleRun run = make("run.dwell");
  const std::size_t before = run.events.size(), all = before + 9000;
  for (std::size_t i = before; i < all; ++i)
    run.events.push_back({100, "2026-07-01T10:12:10.250000Z", "action", std::string(4000, 'x'), {}, "", "", ""});
  write(run, key);
  const Outcome json = test::run({"show", "--json", run.path});
  EXPECT_EQ(json.code, 0) << json.err;
  EXPECT_EQ(schema.faults_of_text("shown_run", json.out), "");
  const auto shown = nlohmann::json::parse(json.out);
  const std::size_t left_out = shown["left_out"]["events"].get<std::size_t>();
  EXPECT_GT(left_out, 0u);
  EXPECT_EQ(shown["events"].size() + left_out, all);
  EXPECT_EQ(shown["left_out"]["dwells"], 0);
  const Outcome page = test::run({"show", run.path});
  EXPECT_EQ(page.code, 0);
  EXPECT_TRUE(holds(page.out, "and " + std::to_string(left_out) + " more events and losses, left out")) << page.err;
}

TEST_F(RecordVerbs, ShowAsJsonHoldsTheEntriesAsTheyAre) {
  const std::string run = written("run.dwell");
  const auto json = nlohmann::json::parse(test::run({"show", "--json", run}).out);
  EXPECT_EQ(json["state"], "closed");
  EXPECT_EQ(json["header"]["id"], "0123456789abcdef0123456789abcdef");
  EXPECT_EQ(json["header"]["rig"]["text"], "# the rig file");
  EXPECT_EQ(json["end"]["samples"], 4000);
  EXPECT_EQ(json["events"].size(), 3u);
  EXPECT_EQ(json["dwells"][0]["index"], 1);
  EXPECT_EQ(json["key"], key.public_key().fingerprint());
}

// Its first block alone is looked at, for the instant of the first record.
TEST_F(RecordVerbs, ShowDoesNotReadTheStream) {
  const std::string run = written("run.dwell");
  alter(run, "UPDATE entry SET body = zeroblob(1000000) WHERE kind = 'stream' AND seq > 2");
  const Outcome outcome = test::run({"show", run});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_TRUE(holds(outcome.out, "dwell 1")) << outcome.out;
}

TEST_F(RecordVerbs, RunsListsAFolderInTheirOrder) {
  SampleRun later = make("a.dwell");
  later.header.run = 18;
  later.header.label = "second";
  later.closed = false;
  write(later, key);
  (void)written("b.dwell");
  (void)folder.file("notes.txt", "no run");
  const Outcome outcome = test::run({"runs", folder.path("")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  std::istringstream lines(outcome.out);
  std::string title, first, second, none;
  std::getline(lines, title);
  std::getline(lines, first);
  std::getline(lines, second);
  EXPECT_TRUE(holds(first, " 17  2026-07-01 10:12:00")) << first;
  EXPECT_TRUE(holds(first, "closed")) << first;
  EXPECT_TRUE(holds(first, "20.0 s")) << first;
  EXPECT_TRUE(holds(second, " 18  ")) << second;
  EXPECT_TRUE(holds(second, "cut off")) << second;
  EXPECT_TRUE(holds(second, "second")) << second;
  EXPECT_FALSE(std::getline(lines, none)) << none;
  const auto json = nlohmann::json::parse(test::run({"runs", "--json", folder.path("")}).out);
  EXPECT_EQ(json["runs"][0]["run"], 17);
  EXPECT_EQ(json["runs"][0]["dwells"], 1);
  EXPECT_EQ(json["runs"][1]["state"], "cut off");
  EXPECT_EQ(test::run({"runs", folder.path("")}).err, "");
}

TEST_F(RecordVerbs, RunsDoesNotPadItsRowsToALabelThatNoServiceGives) {
  SampleRun foreign = make("a.dwell");
  foreign.header.label = std::string(100'000, 'l');
  write(foreign, key);
  (void)written("b.dwell");
  std::istringstream lines(test::run({"runs", folder.path("")}).out);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(width(line), 300u) << line.substr(0, 100);
}

TEST_F(RecordVerbs, RunsTellsAFileThatCannotBeReadAndListsTheOthers) {
  (void)written("a.dwell");
  (void)folder.file("b.dwell", "no database");
  const Outcome outcome = test::run({"runs", folder.path("")});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(holds(outcome.out, "unreadable")) << outcome.out;
  EXPECT_TRUE(holds(outcome.out, " 17  ")) << outcome.out;
}

TEST_F(RecordVerbs, RunsAsksTheService) {
  test::ScriptedServer server({{test::http_reply(200, R"({"runs":[]})")}});
  const Outcome outcome = test::run({"runs", "--url", server.url()});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "no run has been recorded\n");
  EXPECT_TRUE(holds(server.requests().at(0), "GET /api/v1/runs ")) << server.requests().at(0);
}

TEST(RunSummary, TellsSizesAndDurationsAsPeopleDo) {
  EXPECT_EQ(ctl::bytes_text(0), "0 B");
  EXPECT_EQ(ctl::bytes_text(999), "999 B");
  EXPECT_EQ(ctl::bytes_text(1234567), "1.23 MB");
  EXPECT_EQ(ctl::bytes_text(999.6e3), "1.00 MB");
  EXPECT_EQ(ctl::bytes_text(10e9), "10.0 GB");
  EXPECT_EQ(ctl::duration_text(79.33), "79.3 s");
  EXPECT_EQ(ctl::duration_text(723), "12 min 3 s");
  EXPECT_EQ(ctl::duration_text(12000), "3 h 20 min");
}

}  // namespace
}  // namespace dwell
