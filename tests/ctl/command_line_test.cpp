// dwellctl as its users see it: the program is started, its exit code and both its outputs are looked at.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include "config/rig_file.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/verification_json.hpp"
#include "tests/ctl/program.hpp"
#include "tests/ctl/sample_dwell.hpp"
#include "tests/ctl/sample_text.hpp"
#include "tests/ctl/scripted_server.hpp"
#include "tests/ctl/small_rig.hpp"
#include "tests/ctl/temporary.hpp"

namespace dwell {
namespace {

using Json = nlohmann::ordered_json;
using test::contents;
using test::http_reply;
using test::kRig;
using test::Outcome;
using test::recording;
using test::Reply;
using test::run;
using test::sample_text;
using test::ScriptedServer;
using test::settling_text;
using test::stale_text;

TEST(CommandLine, WrongUsageIsExitCode2) {
  for (const std::vector<std::string>& wrong : {std::vector<std::string>{},
                                                {"dance"},
                                                {"status", "--nonsense"},
                                                {"identify"},
                                                {"verify", "--rig", "rig.toml"},
                                                {"verify", "start.csv"},
                                                {"verify", "--dwell", "1"},
                                                {"watch", "--interval", "no"},
                                                {"status", "--url", "nowhere"},
                                                {"watch", "--truth", "/nonexistent"}}) {
    const Outcome outcome = run(wrong);
    EXPECT_EQ(outcome.code, 2) << (wrong.empty() ? "" : wrong[0]);
    EXPECT_NE(outcome.err, "");
  }
}

// As a shell's <(command) makes it: it can be read once.
TEST(CommandLine, StatusReadsTheTokenOnce) {
  int pipe[2] = {-1, -1};
  ASSERT_EQ(::pipe(pipe), 0);
  const std::string token = "0123456789abcdef0123456789abcdef";
  ASSERT_EQ(::write(pipe[1], (token + "\n").c_str(), token.size() + 1), static_cast<ssize_t>(token.size() + 1));
  ::close(pipe[1]);
  ScriptedServer server({{http_reply(200, sample_text())}, {http_reply(200, R"({"gpio":{}})")}});
  const Outcome outcome = run({"status", "--url", server.url(), "--token-file", "/dev/fd/" + std::to_string(pipe[0])});
  ::close(pipe[0]);
  EXPECT_TRUE(outcome.code == 0 || outcome.code == 1) << outcome.code << outcome.err;
  ASSERT_EQ(server.requests().size(), 2U);
  for (const std::string& request : server.requests())
    EXPECT_NE(request.find("Authorization: Bearer " + token + "\r\n"), std::string::npos) << request;
}

TEST(CommandLine, ListsOnlyTheVerbsThatExist) {
  const Outcome outcome = run({"--help"});
  EXPECT_EQ(outcome.code, 0);
  for (const char* verb :
       {"status", "watch", "channels", "dwells", "start", "stop", "label", "rearm", "check", "identify", "replay",
        "verify", "export", "audit", "runs", "show", "sign", "keygen", "report"}) {
    EXPECT_NE(outcome.out.find("\n  " + std::string(verb) + " "), std::string::npos) << verb;
  }
  for (const char* verb : {"reload", "tare"}) {
    EXPECT_EQ(outcome.out.find("\n  " + std::string(verb) + " "), std::string::npos) << verb;
  }
}

TEST(CommandLine, AServiceThatIsNotThereIsExitCode3) {
  std::string address;
  {
    const ScriptedServer server({});
    address = server.url();
  }
  for (const char* verb : {"status", "watch", "channels", "dwells", "verify"}) {
    const Outcome outcome = run({verb, "--url", address});
    EXPECT_EQ(outcome.code, 3) << verb;
    EXPECT_EQ(outcome.err, "dwellctl: " + address + ": Connection refused\n") << verb;
    EXPECT_EQ(outcome.out, "") << verb;
  }
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"check", "--control", "/nonexistent/control"}, {"check"}}) {
    const Outcome check = run(words);
    EXPECT_EQ(check.code, 3);
    EXPECT_NE(check.err.find("dwellctl check --rig FILE"), std::string::npos) << check.err;
  }
}

TEST(CommandLine, VerifyWithoutARecordingAsksTheService) {
  Verification v = test::sample_verification();
  const std::string adequate = dump(json_value(v, test::sample_rig(), test::sample_dwell()));
  v.verdict = Verdict::not_verified;
  const std::string unverified = dump(json_value(v, test::sample_rig(), test::sample_dwell()));
  ScriptedServer server({Reply{http_reply(200, adequate)}, Reply{http_reply(200, adequate)},
                         Reply{http_reply(200, unverified)}, Reply{http_reply(200, "{}")}});
  const Outcome text = run({"verify", "--url", server.url()});
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_NE(text.out.find("verdict     adequate for predictions within 5 %"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("evidence    dwell 1, transient from 0.20 s to 6.42 s"), std::string::npos) << text.out;
  const Outcome json = run({"verify", "--json", "--url", server.url()});
  EXPECT_EQ(json.code, 0);
  EXPECT_EQ(Json::parse(json.out), Json::parse(adequate));
  EXPECT_EQ(run({"verify", "--url", server.url()}).code, 1);
  EXPECT_EQ(run({"verify", "--url", server.url()}).code, 3) << "what answers is not the service";
}

TEST(CommandLine, StatusIsOneScreenAndNoUnlessMeasuring) {
  // For people it asks for the health as well, which tells of the GPIO lines.
  const std::string open = R"({"gpio":{"interlock":{"works":true,"reason":null,"level":0}}})";
  ScriptedServer server({Reply{http_reply(200, sample_text())}, Reply{http_reply(404, "{}")},
                         Reply{http_reply(200, settling_text())}, Reply{http_reply(200, open)},
                         Reply{http_reply(200, sample_text())}});
  const Outcome measuring = run({"status", "--url", server.url()});
  EXPECT_EQ(measuring.code, 0) << measuring.err;
  EXPECT_EQ(measuring.out.substr(0, measuring.out.find('\n')), "dwell 1 · measuring, 24.6 s of data");
  EXPECT_NE(measuring.out.find("24.010 ±   0.027 kN/m"), std::string::npos);
  const Outcome settling = run({"status", "--url", server.url()});
  EXPECT_EQ(settling.code, 1);
  EXPECT_NE(settling.out.find("about 3.2 s left"), std::string::npos);
  EXPECT_NE(settling.out.find("interlock  open"), std::string::npos);
  EXPECT_EQ(Json::parse(run({"status", "--json", "--url", server.url()}).out), Json::parse(sample_text()));
}

// A script that asks for the exit code must not take numbers that people are told not to rely on.
TEST(CommandLine, StatusIsNoWhileItsNumbersMustNotBeReliedOn) {
  Dwell dwell = test::sample_dwell();
  dwell.doubts = {{{1}, "y1 and y2 look swapped"}};
  ScriptedServer server(
      {Reply{http_reply(200, to_json(dwell, test::sample_rig(), test::sample_run()))}, Reply{http_reply(200, "{}")}});
  const Outcome outcome = run({"status", "--url", server.url()});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.out.find("do not rely on element 1: y1 and y2 look swapped"), std::string::npos) << outcome.out;
}

// The estimation hangs, the rest of the service answers: it said "measuring", with exit code 0.
TEST(CommandLine, StatusOfAStaleDwellIsNoAndSaysHowOldItIsAndWhy) {
  const std::string broken = R"({"status":"fault","reason":"thread estimate has not turned for 5.6 s","gpio":{}})";
  ScriptedServer server(
      {Reply{http_reply(200, stale_text())}, Reply{http_reply(503, broken)}, Reply{http_reply(200, stale_text())}});
  const Outcome outcome = run({"status", "--url", server.url()});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.out.substr(0, outcome.out.find('\n')),
            "STALE, from 5.7 s ago: dwell 1 · measuring, 24.6 s of data");
  EXPECT_NE(outcome.out.find("thread estimate has not turned for 5.6 s"), std::string::npos) << outcome.out;
  const Outcome json = run({"status", "--json", "--url", server.url()});
  EXPECT_EQ(json.code, 1);
  EXPECT_EQ(Json::parse(json.out)["estimate_age_s"], 5.7);
}

TEST(CommandLine, RearmAsksTheServiceAndSaysWhatCameOfIt) {
  const test::TemporaryFolder folder;
  ScriptedServer server({Reply{"{\"done\":true}\n", true}, Reply{"{\"done\":true}\n", true},
                         Reply{"{\"error\":\"too many at once; try again\"}\n", true}, Reply{"rubbish\n", true}},
                        folder.path("control"));
  const std::vector<std::string> rearm{"rearm", "--control", folder.path("control")};
  const Outcome done = run(rearm);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(done.out, "rearmed: the dwell ends here, and the rig settles anew\n");
  EXPECT_EQ(server.requests().at(0), R"({"verb":"rearm"})");
  EXPECT_EQ(run({"rearm", "--control", folder.path("control"), "--json"}).out, "{\"done\":true}\n");
  const Outcome refused = run(rearm);
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("too many at once; try again"), std::string::npos);
  EXPECT_EQ(run(rearm).code, 3);
  EXPECT_EQ(run({"rearm", "--control", "/nonexistent/control"}).code, 3);
}

TEST(CommandLine, StartAndStopAskTheServiceAndSayWhatCameOfIt) {
  const test::TemporaryFolder folder;
  const Reply done{"{\"done\":true}\n", true}, no{"{\"error\":\"nothing to stop: no run goes on\"}\n", true};
  const Reply slow{"{\"done\":true,\"recording\":null}\n", true};
  ScriptedServer server({done, done, done, done, no, slow}, folder.path("control"));
  const std::vector<std::string> at{"--control", folder.path("control")};
  const auto with = [&at](std::vector<std::string> words) {
    words.insert(words.end(), at.begin(), at.end());
    return run(words);
  };
  const Outcome started = with({"start", "--label", "sweep 3", "--comment", "new damper"});
  EXPECT_EQ(started.code, 0) << started.err;
  EXPECT_EQ(started.out, "started: run \"sweep 3\" begins here and ends with \"dwellctl stop\"\n");
  EXPECT_EQ(server.requests().at(0), R"({"verb":"start","comment":"new damper","label":"sweep 3"})");
  EXPECT_EQ(with({"start", "--label", "a", "--json"}).out, "{\"done\":true}\n");
  EXPECT_EQ(with({"stop"}).out, "stopped: the run ends here\n");
  EXPECT_EQ(server.requests().at(2), R"({"verb":"stop"})");
  EXPECT_EQ(with({"label", "oil film", "--comment", "as seen"}).out, "labelled: the run is \"oil film\"\n");
  EXPECT_EQ(server.requests().at(3), R"({"verb":"label","comment":"as seen","label":"oil film"})");
  const Outcome refused = with({"stop", "--comment", "done"});
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("nothing to stop: no run goes on"), std::string::npos) << refused.err;
  const Outcome asked = with({"start", "--label", "slow"});
  EXPECT_EQ(asked.code, 0) << asked.err;
  EXPECT_EQ(asked.out.find("asked: run \"slow\"; whether it is recorded is not known yet"), 0u) << asked.out;
  EXPECT_EQ(run({"start", "--label", "a", "--control", "/nonexistent/control"}).code, 3);
  for (const char* verb : {"start", "label"}) EXPECT_EQ(with({verb}).code, 2) << verb << " without a label";
}

TEST(CommandLine, AnswersThatAreNotTheServicesAreExitCode3) {
  for (const std::string& text :
       {http_reply(200, "<html>"), http_reply(200, "{}"), http_reply(503, R"({"error":"starting","status":503})"),
        http_reply(200, "[[[[[["), http_reply(200, R"({"channels":7,"dwells":{}})"),
        std::string("220 mail ready\r\n")}) {
    for (const char* verb : {"status", "channels", "dwells"}) {
      ScriptedServer server({Reply{text}});
      const Outcome outcome = run({verb, "--url", server.url()});
      EXPECT_EQ(outcome.code, 3) << verb << " " << text;
      EXPECT_NE(outcome.err, "");
      EXPECT_EQ(outcome.out, "");
    }
  }
}

TEST(CommandLine, ChannelsAndDwellsAreTablesOrJson) {
  const std::string channels = R"({"channels":[{"name":"y0","value":1.5,"unit":"mm","status":"ok"}]})";
  const std::string runs =
      R"({"runs":[{"state":"closed","dwells":4,"dwells_at":"/a"},)"
      R"({"state":"cut off","dwells":2,"dwells_at":"/b"},{"state":"closed","dwells":0,"dwells_at":null},)"
      R"({"state":"recording","dwells":3,"dwells_at":null}]})";
  const std::string dwells = R"({"rig":"bench","total":7,"dwells":[)" + sample_text() + "]}";
  ScriptedServer server({Reply{http_reply(200, channels)}, Reply{http_reply(200, channels)},
                         Reply{http_reply(200, dwells)}, Reply{http_reply(200, R"({"runs":[]})")},
                         Reply{http_reply(200, dwells)}, Reply{http_reply(200, R"({"dwells":[]})")},
                         Reply{http_reply(200, runs)}});
  EXPECT_NE(run({"channels", "--url", server.url()}).out.find("y0       ok      1.5 mm"), std::string::npos);
  EXPECT_EQ(Json::parse(run({"channels", "--json", "--url", server.url()}).out), Json::parse(channels));
  const Outcome table = run({"dwells", "--url", server.url()});
  EXPECT_EQ(table.code, 0) << table.err;
  EXPECT_NE(table.out.find("the last 1 of 7\n"), std::string::npos);
  EXPECT_EQ(Json::parse(run({"dwells", "--json", "--url", server.url()}).out), Json::parse(dwells));
  EXPECT_EQ(run({"dwells", "--url", server.url()}).out,
            "no dwell of this run has been completed\n"
            "earlier runs: 6 dwells in 2 files; dwellctl runs lists them, dwellctl show FILE and the page show the "
            "dwells of one\n");
}

TEST(CommandLine, CheckAsksTheServiceAndIsNoIfAChannelIsSilent) {
  const test::TemporaryFolder folder;
  const std::string good =
      R"({"channels":[{"name":"y0","value":1.5,"unit":"mm","rate_hz":500,"latency_s":0.001,"status":"ok"}]})";
  const std::string bad = R"({"channels":[{"name":"y0","value":null,"unit":"mm","status":"timeout"}]})";
  ScriptedServer server({Reply{good + "\n", true}, Reply{bad + "\n", true}, Reply{good + "\n", true},
                         Reply{"{\"error\":\"unknown verb\"}\n", true}, Reply{"rubbish\n", true}},
                        folder.path("control"));
  const auto check = [&folder](std::vector<std::string> more) {
    more.insert(more.begin(), {"check", "--control", folder.path("control")});
    return run(more);
  };
  EXPECT_EQ(check({}).code, 0);
  const Outcome silent = check({});
  EXPECT_EQ(silent.code, 1);
  EXPECT_NE(silent.out.find("timeout"), std::string::npos);
  EXPECT_EQ(Json::parse(check({"--json"}).out), Json::parse(good));
  EXPECT_EQ(check({}).code, 1);
  EXPECT_EQ(check({}).code, 3);
  EXPECT_EQ(server.requests().at(0), R"({"verb":"check"})");
}

TEST(CommandLine, CheckProbesTheDevicesOfARigFileItself) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", kRig);
  (void)folder.file("data.csv", recording(0.5, "t,y0,reaction"));
  const Outcome outcome = run({"check", "--rig", rig, "--json"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const Json channels = Json::parse(outcome.out)["channels"];
  ASSERT_EQ(channels.size(), 2U);
  EXPECT_EQ(channels[0]["name"], "y0");
  EXPECT_EQ(channels[0]["status"], "ok");
  EXPECT_TRUE(channels[1]["value"].is_number());
  EXPECT_EQ(run({"check", "--rig", folder.file("bad.toml", "[rig]\nname = 3\n")}).code, 2);
}

// Two programs on one serial line would take each other's answers.
TEST(CommandLine, CheckOfARigFileThatTheServiceServesAsksTheService) {
  const test::TemporaryFolder folder;
  const std::string rig = folder.file("rig.toml", kRig);
  (void)folder.file("data.csv", recording(0.5, "t,y0,reaction"));
  const std::string sha256 = config::load(rig, nullptr)->sha256;
  const std::string status = R"({"health":{"rig_sha256":")" + sha256 + "\"}}\n";
  const std::string foreign = R"({"health":{"rig_sha256":"0"}})"
                              "\n";
  const std::string served =
      R"({"channels":[{"name":"y0","value":1.5,"unit":"mm","rate_hz":500,"latency_s":0.001,"status":"ok"}]})"
      "\n";
  ScriptedServer server({Reply{status, true}, Reply{served, true}, Reply{foreign, true}}, folder.path("control"));
  const Outcome asked = run({"check", "--rig", rig, "--control", folder.path("control"), "--json"});
  EXPECT_EQ(asked.code, 0) << asked.err;
  EXPECT_EQ(Json::parse(asked.out)["channels"].size(), 1U);
  EXPECT_NE(asked.err.find("the service measures with"), std::string::npos) << asked.err;
  // Of another rig file the devices are free.
  const Outcome probed = run({"check", "--rig", rig, "--control", folder.path("control"), "--json"});
  EXPECT_EQ(probed.code, 0) << probed.err;
  EXPECT_EQ(Json::parse(probed.out)["channels"].size(), 2U);
}

TEST(CommandLine, CheckWithoutAServiceHintsAtTheRigFile) {
  const Outcome outcome = run({"check", "--control", "/nonexistent/control"});
  EXPECT_EQ(outcome.code, 3);
  EXPECT_NE(outcome.err.find("--rig FILE"), std::string::npos) << outcome.err;
}

TEST(CommandLine, CheckIsNoWhereADeviceDoesNotAnswer) {
  const test::TemporaryFolder folder;
  std::string port;
  {
    const ScriptedServer server({});
    port = std::to_string(server.port());
  }
  std::string rig = kRig;
  const auto replace = [&rig](const std::string& what, const std::string& by) {
    for (auto at = rig.find(what); at != std::string::npos; at = rig.find(what, at + by.size())) {
      rig.replace(at, what.size(), by);
    }
  };
  replace("driver = \"replay\"\nfile = \"data.csv\"",
          "driver = \"modbus\"\ntransport = \"tcp\"\nhost = \"127.0.0.1\"\nrate = 100\nport = " + port);
  replace("device = \"recording\"\nmeasures = \"d",
          "device = \"recording\"\nregister = 0\ntype = \"float32\"\nmeasures = \"d");
  replace("device = \"recording\"\nmeasures = \"f",
          "device = \"recording\"\nregister = 2\ntype = \"float32\"\nmeasures = \"f");
  const Outcome outcome = run({"check", "--rig", folder.file("rig.toml", rig)});
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  const std::string reason = "127.0.0.1:" + port + ": Connection refused";
  EXPECT_NE(outcome.out.find("\ny0        no answer  recording "), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("  " + reason + "\n"), std::string::npos) << outcome.out;
  const Json channel = Json::parse(run({"check", "--rig", folder.path("rig.toml"), "--json"}).out)["channels"][0];
  EXPECT_EQ(channel["status"], "no answer");
  EXPECT_EQ(channel.value("reason", ""), reason);
}

TEST(CommandLine, CheckIsNoWhereAChannelIsGatedAndSaysSo) {
  const test::TemporaryFolder folder;
  const std::string gated =
      R"({"channels":[{"name":"y0","value":1.5,"unit":"mm","status":"ok","reason":null},)"
      R"({"name":"y2","value":1.7e-29,"unit":"mm","status":"gated","reason":"check type and order"}]})"
      "\n";
  ScriptedServer server({Reply{gated, true}}, folder.path("control"));
  const Outcome outcome = run({"check", "--control", folder.path("control")});
  EXPECT_EQ(outcome.code, 1) << outcome.out;
  EXPECT_NE(outcome.err.find("y2 answers, and its readings cannot be relied on: gated: check type and order"),
            std::string::npos)
      << outcome.err;
}

TEST(CommandLine, AFullDiskIsNotSuccess) {
  if (::access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  ScriptedServer server({Reply{http_reply(200, sample_text())}});
  const std::string command = std::string(DWELLCTL) + " status --url " + server.url() + " >/dev/full 2>/dev/null";
  const int status = std::system(command.c_str());
  EXPECT_EQ(WEXITSTATUS(status), 2);
}

}  // namespace
}  // namespace dwell
