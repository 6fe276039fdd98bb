// export and report as their users see them: exit codes, what is said, what is left behind.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/api_schema.hpp"
#include "tests/handon/handed_run.hpp"

namespace dwell {
namespace {

struct Said {
  int code = -1;
  std::string out, err;
};

class HandonCommand : public ::testing::Test {
 protected:
  HandonCommand() {
    run_.length_s = 3.0;
    test::write(run_, scratch_.path("run.dwell"));
  }
  // Arguments as in a shell, within the scratch directory.
  [[nodiscard]] Said say(const std::string& arguments) const { return shell(DWELLCTL " " + arguments); }
  [[nodiscard]] Said shell(const std::string& line) const {
    const std::string command = "cd " + scratch_.path() + " && (" + line + ") >said.out 2>said.err </dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, record::Scratch::read(scratch_.path("said.out")),
            record::Scratch::read(scratch_.path("said.err"))};
  }
  [[nodiscard]] bool there(const std::string& name) const { return std::filesystem::exists(scratch_.path(name)); }
  // One letter of the run's end is another one.
  void tamper() const {
    std::string bytes = record::Scratch::read(run_.path);
    const std::size_t at = bytes.rfind("\"why\"");
    ASSERT_NE(at, std::string::npos);
    bytes[bytes.find("operator", at)] = 'O';
    scratch_.write("run.dwell", bytes);
  }

  record::Scratch scratch_;
  test::HandedRun run_;
};

TEST_F(HandonCommand, JsonIsAsTheSchemaSays) {
  const test::ApiSchema schema;
  for (const char* format : {"csv", "hdf5", "uff"}) {
    const Said said = say(std::string("export run.dwell --json --overwrite -o out --format ") + format);
    EXPECT_EQ(schema.faults_of_text("exported_run", said.out), "") << format << said.err;
  }
  EXPECT_EQ(schema.faults_of_text("report", say("report run.dwell -o out.html --json").out), "");
}

TEST_F(HandonCommand, ExportsInEachFormatAndSaysWhatWasWritten) {
  const Said csv = say("export run.dwell --format csv -o out.csv");
  EXPECT_EQ(csv.code, 0) << csv.err;
  EXPECT_NE(csv.out.find(" samples; the rig file: out.rig.toml"), std::string::npos) << csv.out;
  EXPECT_EQ(say("identify --rig out.rig.toml --method harmonic out.csv").code, 0);
  const Said hdf5 = say("export run.dwell --format hdf5 -o out.h5 --json");
  EXPECT_EQ(hdf5.code, 0) << hdf5.err;
  EXPECT_NE(hdf5.out.find("\"audit\": \"intact, key "), std::string::npos) << hdf5.out;
  const Said uff = say("export run.dwell --format uff -o out.uff --from 0.5 --to 2.5");
  EXPECT_EQ(uff.code, 0) << uff.err;
  EXPECT_NE(uff.out.find("even values in 2 datasets"), std::string::npos) << uff.out;
  const Said page = say("report run.dwell -o out.html");
  EXPECT_EQ(page.code, 0) << page.err;
  EXPECT_NE(page.out.find("out.html: the file is intact"), std::string::npos) << page.out;
}

TEST_F(HandonCommand, AReportThatWasComparedWithNoLedgerSaysSo) {
  scratch_.write("old.dwell-ledger", std::string(4096, 'x'));
  const Said page = say("report run.dwell -o out.html --ledger old.dwell-ledger");
  EXPECT_EQ(page.code, 1) << page.err;
  const std::string why = "compared with no ledger, since the one asked for is broken: ";
  EXPECT_NE(page.out.find(why), std::string::npos) << page.out;
  EXPECT_NE(record::Scratch::read(scratch_.path("out.html")).find(why), std::string::npos);
}

TEST_F(HandonCommand, AnExportWithoutReadingsIsExitCode1) {
  for (const char* format : {"csv", "hdf5", "uff"}) {
    const Said said =
        say(std::string("export run.dwell --overwrite -o out --from 1.0021 --to 1.0029 --format ") + format);
    EXPECT_EQ(said.code, 1) << format << said.out;
    EXPECT_NE(said.err.find("out: holds no readings"), std::string::npos) << said.err;
  }
}

TEST_F(HandonCommand, ExportsNothingOfATamperedRunUnlessAskedTo) {
  tamper();
  const Said refused = say("export run.dwell --format csv -o out.csv");
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("run.dwell: tampered: "), std::string::npos) << refused.err;
  EXPECT_FALSE(there("out.csv"));
  const Said unchecked = say("export run.dwell --format csv -o out.csv --unchecked");
  EXPECT_EQ(unchecked.code, 0) << unchecked.err;
  EXPECT_NE(record::Scratch::read(scratch_.path("out.csv")).find("; head not checked; audit: not audited"),
            std::string::npos);
  const Said page = say("report run.dwell -o out.html");
  EXPECT_EQ(page.code, 1) << page.out;
  EXPECT_NE(record::Scratch::read(scratch_.path("out.html")).find("class=\"state tampered\""), std::string::npos);
}

// Where the stream, a result or an event cannot be read, the page holds what stands before.
TEST_F(HandonCommand, ReportsATamperedRunOfWhichABlockCannotBeRead) {
  std::string bytes = record::Scratch::read(run_.path);
  const std::string frame = "\x28\xb5\x2f\xfd";  // of zstd
  const std::size_t first = bytes.find(frame), second = bytes.find(frame, first + 1);
  ASSERT_NE(second, std::string::npos);
  for (std::size_t i = 0; i < 32; ++i) bytes[second + 8 + i] = 'x';
  std::ofstream(run_.path, std::ios::binary) << bytes;
  const Said page = say("report run.dwell -o out.html");
  EXPECT_EQ(page.code, 1) << page.err;
  const std::string html = record::Scratch::read(scratch_.path("out.html"));
  EXPECT_NE(html.find("class=\"state tampered\""), std::string::npos);
  EXPECT_NE(html.find("Parts of the file cannot be read"), std::string::npos);
}

TEST_F(HandonCommand, ATamperedFileThatCannotBeReadIsExitCode1) {
  std::string bytes = record::Scratch::read(run_.path);
  const std::size_t at = bytes.find("\"begun_by\"");
  ASSERT_NE(at, std::string::npos);
  bytes[at + 1] = 'B';  // a member of the header is missing
  scratch_.write("run.dwell", bytes);
  for (const char* verb : {"export run.dwell --format csv -o out", "report run.dwell -o out"}) {
    const Said refused = say(verb);
    EXPECT_EQ(refused.code, 1) << verb;
    EXPECT_NE(refused.err.find("run.dwell: tampered: "), std::string::npos) << refused.err;
    EXPECT_NE(refused.err.find("it cannot be read as a run"), std::string::npos) << refused.err;
    EXPECT_FALSE(there("out"));
  }
}

TEST_F(HandonCommand, AdvisesNothingForAFileThatIsNoRun) {
  for (const std::string& bytes : {std::string(), std::string("no database\n")}) {
    std::ofstream(scratch_.path("other.dwell"), std::ios::binary) << bytes;
    const Said said = say("export other.dwell --format csv -o out.csv");
    EXPECT_EQ(said.code, 2) << said.err;
    EXPECT_EQ(said.err.find("--unchecked"), std::string::npos) << said.err;
    EXPECT_EQ(say("report other.dwell -o out.html").code, 2);
  }
}

// HDF5 cannot close such a file.
TEST_F(HandonCommand, ADiskThatIsFullIsAnErrorInEachFormat) {
  for (const char* format : {"csv", "hdf5", "uff"}) {
    const Said said =
        shell("trap '' XFSZ; ulimit -f 8; " DWELLCTL " export run.dwell --format " + std::string(format) + " -o full");
    EXPECT_EQ(said.code, 2) << format << ": " << said.err;
    EXPECT_NE(said.err.find("cannot "), std::string::npos)
        << "cannot be written, or HDF5 cannot write it: " << said.err;
    EXPECT_FALSE(there("full") || there("full.part")) << format;
  }
}

TEST_F(HandonCommand, AnEmptyOptionIsNotTakenForNone) {
  for (const char* option : {"--from ''", "--to ''", "--dwell ''"}) {
    const Said said = say(std::string("export run.dwell --format csv -o out.csv ") + option);
    EXPECT_EQ(said.code, 2) << option;
    EXPECT_NE(said.err.find(" is empty; expected a value"), std::string::npos) << said.err;
    EXPECT_FALSE(there("out.csv"));
  }
}

// A child file holds no stream: nothing may be said about readings, samples or losses as if there were none.
TEST_F(HandonCommand, ReportsAChildFileAsWhatItIs) {
  ASSERT_EQ(say("export run.dwell --format csv -o out.csv").code, 0);
  ASSERT_EQ(say("keygen --key own.key").code, 0);
  const Said made = say("replay run.dwell --rig out.rig.toml -o child.dwell --key own.key");
  ASSERT_TRUE(there("child.dwell")) << made.err;
  ASSERT_EQ(say("report child.dwell -o child.html").code, 0);
  const std::string page = record::Scratch::read(scratch_.path("child.html"));
  const std::string id = test::select(run_).header().id;
  EXPECT_NE(page.find("<h1>Child file of run " + id.substr(0, 8)), std::string::npos);
  EXPECT_NE(page.find("Child file of run " + id + ", head "), std::string::npos);
  for (const char* untrue : {"Losses and faults", "Readings over time", "<th>samples</th>", "0.0 s</td>", "<td>0</td>"})
    EXPECT_EQ(page.find(untrue), std::string::npos) << untrue;
  const Said page_of_text = say("show child.dwell");
  EXPECT_NE(page_of_text.out.find("child file of run " + id.substr(0, 8)), std::string::npos) << page_of_text.out;
  EXPECT_EQ(page_of_text.out.find("0 samples"), std::string::npos) << page_of_text.out;
  EXPECT_NE(page_of_text.out.find("covers     3.0 s"), std::string::npos) << page_of_text.out;
  const Said list = say("runs .");
  EXPECT_NE(list.out.find("3.0 s  closed"), std::string::npos) << list.out;
  for (const char* format : {"csv", "hdf5", "uff"}) {
    const Said refused = say(std::string("export child.dwell -o none --format ") + format);
    EXPECT_EQ(refused.code, 2) << format;
    EXPECT_NE(refused.err.find("child.dwell holds no stream: it was computed from run " + id), std::string::npos)
        << refused.err;
    EXPECT_FALSE(there("none"));
  }
}

TEST_F(HandonCommand, TheReportTellsWhichPersonsKeyIsPinned) {
  ASSERT_EQ(say("keygen --key own.key --name anna@desk").code, 0);
  ASSERT_EQ(say("sign run.dwell --meaning reviewed --name Anna --key own.key --control none").code, 0);
  const auto page = [&](const std::string& options) {
    EXPECT_EQ(say("report run.dwell --overwrite -o out.html " + options).code, 0);
    return record::Scratch::read(scratch_.path("out.html"));
  };
  EXPECT_NE(page("--person own.key.pub").find("with the pinned key anna@desk "), std::string::npos);
  const std::string of_nobody = page("");
  EXPECT_NE(of_nobody.find(", not trusted"), std::string::npos);
  EXPECT_EQ(of_nobody.find("with the pinned key"), std::string::npos);
}

TEST_F(HandonCommand, TrustsThePinnedKeyAlone) {
  const std::string vkey = test::select(run_).header().vkey;
  EXPECT_NE(say("report run.dwell --overwrite -o out.html --key '" + vkey + "'").out.find(" trusted"),
            std::string::npos);
  EXPECT_EQ(say("report run.dwell --overwrite -o out.html --key '" + vkey + "'").out.find("not trusted"),
            std::string::npos);
  const Said wrong = say("report run.dwell --overwrite -o out.html --key nowhere");
  EXPECT_EQ(wrong.code, 2);
  EXPECT_NE(wrong.err.find("nowhere: there is no such file"), std::string::npos) << wrong.err;
}

TEST_F(HandonCommand, WritesInPlaceOfNothingButARegularFileThatWasGivenUp) {
  const auto writes = [](const std::string& target, bool overwrite) {
    const std::string end = " -o " + target + (overwrite ? " --overwrite" : "");
    return std::vector<std::string>{"export run.dwell --format csv" + end, "export run.dwell --format hdf5" + end,
                                    "export run.dwell --format uff" + end, "report run.dwell" + end};
  };
  const std::string run = record::Scratch::read(run_.path);
  scratch_.write("renamed.csv", run);
  scratch_.write("other.dwell", "x");
  scratch_.write("text", "x");
  std::filesystem::create_symlink("text", scratch_.path("link"));
  ASSERT_EQ(::mkfifo(scratch_.path("pipe").c_str(), 0644), 0);
  for (const auto& [target, found] :
       {std::pair("renamed.csv", "is a run file or a ledger"), std::pair("other.dwell", "has the name of a run file"),
        std::pair("run.dwell-wal", "has the name of a run file"),
        std::pair("new.dwell-ledger", "has the name of a run"), std::pair("link", "is a link"),
        std::pair("pipe", "is no regular file"), std::pair(".", "is a directory")})
    for (const std::string& command : writes(target, true)) {
      const Said said = say(command);
      EXPECT_EQ(said.code, 2) << command;
      EXPECT_NE(said.err.find(std::string(target) + ": " + found), std::string::npos) << command << ": " << said.err;
    }
  for (const std::string& command : writes("text", false)) {
    const Said said = say(command);
    EXPECT_EQ(said.code, 2) << command;
    EXPECT_NE(said.err.find("text: exists already; expected a new name, or --overwrite"), std::string::npos)
        << said.err;
  }
  EXPECT_EQ(record::Scratch::read(run_.path), run);
  EXPECT_EQ(record::Scratch::read(scratch_.path("renamed.csv")), run);
  EXPECT_EQ(record::Scratch::read(scratch_.path("text")), "x");
  EXPECT_FALSE(there("run.dwell-wal"));
  for (const std::string& command : writes("text", true)) EXPECT_EQ(say(command).code, 0) << command;
}

TEST_F(HandonCommand, WritesAtNoNameOfTheServicesOwnFilesInARecordingDirectory) {
  std::filesystem::create_directory(scratch_.path("runs"));
  ASSERT_EQ(say("keygen --key runs/key").code, 0);
  ASSERT_EQ(say("keygen --key own").code, 0);
  for (const char* name : {"ledger.dwell-ledger", "reserve", "next-18.new", "next-18.new-wal"})
    scratch_.write(std::string("runs/") + name, "the service's");
  const auto contents = [&] {
    std::string all;
    for (const char* name : {"runs/key", "runs/key.pub", "runs/reserve", "runs/next-18.new", "runs/next-18.new-wal"})
      all += record::Scratch::read(scratch_.path(name)) + "\n";
    return all;
  };
  const std::string before = contents();
  for (const auto& [target, found] : {std::pair("runs/key", "has the name of the private key of the service"),
                                      std::pair("runs/key.pub", "has the name of the public key of the service"),
                                      std::pair("runs/key.next", "has the name of the private key of the service"),
                                      std::pair("runs/reserve", "has the name of the room that the service reserves"),
                                      std::pair("runs/next-18.new", "has the name of a run that the service makes"),
                                      std::pair("runs/next-18.new-wal", "has the name of a run that the service makes"),
                                      std::pair("runs/next-19.new", "has the name of a run that the service makes"),
                                      std::pair("own", "is a private key")})
    for (const char* command : {"report run.dwell", "export run.dwell --format csv"}) {
      const Said said = say(std::string(command) + " --overwrite -o " + target);
      EXPECT_EQ(said.code, 2) << command << " " << target;
      EXPECT_NE(said.err.find(std::string(target) + ": " + found), std::string::npos) << said.err;
    }
  EXPECT_EQ(contents(), before);
  EXPECT_FALSE(there("runs/key.next") || there("runs/next-19.new"));
  EXPECT_EQ(say("report run.dwell -o reserve").code, 0) << "elsewhere it is a name as any other";
}

TEST_F(HandonCommand, TheRigFileBesideACsvReplacesNothing) {
  scratch_.write("out.rig.toml", "mine");
  const Said said = say("export run.dwell --format csv -o out.csv");
  EXPECT_EQ(said.code, 2);
  EXPECT_NE(said.err.find("out.rig.toml: exists already"), std::string::npos) << said.err;
  EXPECT_EQ(record::Scratch::read(scratch_.path("out.rig.toml")), "mine");
  EXPECT_FALSE(there("out.csv"));
}

TEST_F(HandonCommand, WrongUsageIsExitCode2AndSaysWhatWasExpected) {
  const auto refused = [this](const std::string& arguments, const std::string& words) {
    const Said said = say(arguments);
    EXPECT_EQ(said.code, 2) << arguments;
    EXPECT_NE(said.err.find(words), std::string::npos) << arguments << ": " << said.err;
  };
  refused("export run.dwell -o out", "expected --format csv, hdf5 or uff");
  refused("export run.dwell --format wav -o out", "wav");
  refused("export run.dwell --format csv -o out --dwell 1 --from 3", "--dwell");
  refused("export run.dwell --format csv -o out --from 3 --to 2", "the range ends before it begins");
  refused("export run.dwell --format csv -o out --from nan", "expected seconds of the run");
  refused("export run.dwell --format csv -o out --to nan", "expected seconds of the run");
  refused("export run.dwell --format csv -o out --dwell 9", "there is no dwell 9 in it; expected 1 to 1");
  refused("export none.dwell --format csv -o out", "none.dwell");
  refused("export run.dwell --format csv -o -", "standard output is no file");
  refused("report run.dwell -o -", "standard output is no file");
  refused("export run.dwell --format csv -o out --from 100 --to 200",
          "the range lies outside of the run, which is from");
  refused("export run.dwell --format hdf5 -o out --in-unit", "--in-unit belongs to --format csv");
  refused("export run.dwell --format csv -o out --binary", "--binary belongs to --format uff");
  EXPECT_FALSE(there("out") || there("-"));
  refused("export run.dwell --format csv -o run.dwell", "is the run file itself");
  refused("report run.dwell -o run.dwell", "is the run file itself");
  scratch_.write("readings.csv", "t,y0,reaction\n");
  refused("export --model readings.csv -o out", "a recording as text needs its rig file: --rig RIG.toml");
  refused("export run.dwell -o out --rig rig.toml", "--model");
  refused("export run.dwell --format uff -o missing/out", "missing/out: cannot be written");
  EXPECT_FALSE(there("out"));
}

}  // namespace
}  // namespace dwell
