// dwelld as a process: its command line, its signals, what it tells systemd.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <vector>

#include "daemon/record/audit.hpp"
#include "daemon/record/run_reader.hpp"
#include "tests/daemon/service_rig.hpp"

namespace dwell {
namespace {

struct ProcessTest : testing::Test {
  void SetUp() override {
    char name[] = "/tmp/dwelld-test-XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    folder = name;
    notify = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string path = folder + "/notify";
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    ASSERT_EQ(bind(notify, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    setenv("NOTIFY_SOCKET", path.c_str(), 1);
    setenv("WATCHDOG_USEC", "2000000", 1);
    unsetenv("WATCHDOG_PID");
    for (const char* unset : {"RUNTIME_DIRECTORY", "LOGS_DIRECTORY", "JOURNAL_STREAM"}) unsetenv(unset);
  }
  void TearDown() override {
    if (child > 0) {
      kill(child, SIGKILL);
      waitpid(child, nullptr, 0);
    }
    close(notify);
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
    std::filesystem::remove_all(folder);
  }
  std::string write(const std::string& name, const std::string& text) {
    std::ofstream(folder + "/" + name) << text;
    return folder + "/" + name;
  }
  [[nodiscard]] std::string read(const std::string& name) const {
    std::ostringstream all;
    all << std::ifstream(folder + "/" + name).rdbuf();
    return all.str();
  }
  // Both outputs go to the file "output".
  void start(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), DWELLD);
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    const std::string output = folder + "/output";
    child = fork();
    if (child != 0) return;
    const int file = open(output.c_str(), O_CREAT | O_WRONLY | O_APPEND, 0600);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    execv(DWELLD, pointers.data());
    _exit(127);
  }
  int wait_for_end() {
    int status = 0;
    waitpid(std::exchange(child, -1), &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  int run(std::vector<std::string> arguments) {
    start(std::move(arguments));
    return wait_for_end();
  }
  // Whether the output holds `text`, or does within 20 s.
  [[nodiscard]] bool said(const std::string& text) const {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (read("output").find(text) == std::string::npos && std::chrono::steady_clock::now() < end)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    return read("output").find(text) != std::string::npos;
  }
  // Whether `text` has been among the notifications, or comes within 20 s.
  bool notified(const std::string& text) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    pollfd ready{notify, POLLIN, 0};
    while (notifications.find(text) == std::string::npos && std::chrono::steady_clock::now() < end) {
      if (poll(&ready, 1, 100) != 1) continue;
      char message[1024];
      const auto size = recv(notify, message, sizeof message, 0);
      if (size > 0) notifications.append(message, static_cast<std::size_t>(size)).append("\n");
    }
    return notifications.find(text) != std::string::npos;
  }

  std::string notifications;
  std::string folder;
  int notify = -1;
  pid_t child = -1;
};

// That it takes less than a second is claimed where the clock counts instructions: tests/vm/scenarios/10-service.sh.
TEST_F(ProcessTest, StopsAtSigtermAndTidiesUp) {
  auto rig = rigsim::Server::start(test::clamped_rig());
  ASSERT_TRUE(rig);
  const std::string control = folder + "/control";
  start({"--config", write("rig.toml", test::rig_file((*rig)->tcp_port())), "--control", control, "--log",
         folder + "/dwelld.log"});
  ASSERT_TRUE(notified("READY=1")) << read("output");
  EXPECT_TRUE(notified("WATCHDOG=1"));
  EXPECT_TRUE(notified("STATUS=settling"));
  test::Client client = test::Client::local(control);
  client.send("{\"verb\":\"status\"}\n");
  EXPECT_NE(client.until("\n").find("\"state\""), std::string::npos);

  kill(child, SIGTERM);
  EXPECT_EQ(wait_for_end(), 0) << read("output");
  EXPECT_TRUE(notified("STOPPING=1"));
  EXPECT_FALSE(std::filesystem::exists(control));
  const std::string log = read("dwelld.log");
  EXPECT_NE(log.find("delivering"), std::string::npos) << log;
  EXPECT_NE(log.find("complete (end)"), std::string::npos) << log;
  EXPECT_NE(log.find("stopped"), std::string::npos) << log;
}

// The drive is on from the start, so a run of the drive goes on before the operator asks.
TEST_F(ProcessTest, RecordsTheDrivesRunAndTheOneThatAnOperatorBrackets) {
  auto rig = rigsim::Server::start(test::clamped_rig());
  ASSERT_TRUE(rig);
  const std::string control = folder + "/control";
  const std::string text = test::rig_file((*rig)->tcp_port()) + "[recording]\ndirectory = \"runs\"\nevery = 0.5\n";
  start({"--config", write("rig.toml", text), "--control", control, "--log", folder + "/dwelld.log"});
  ASSERT_TRUE(notified("READY=1")) << read("output");
  ASSERT_TRUE(notified("STATUS=settling")) << read("output");
  test::Client client = test::Client::local(control);
  const auto ask = [&client](const std::string& line) {
    client.send(line + "\n");
    return client.until("\n");
  };
  EXPECT_EQ(ask(R"({"verb":"start","label":"sweep 3","comment":"new damper"})"), "{\"done\":true}\n");
  EXPECT_NE(ask(R"({"verb":"start","label":"sweep 4"})").find("stop it first"), std::string::npos);
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  for (nlohmann::json now; now["dwell"]["state"] != "settling" || now["health"]["run"]["begun_by"] != "operator";) {
    ASSERT_LT(std::chrono::steady_clock::now(), end) << now.dump(1);
    now = nlohmann::json::parse(ask(R"({"verb":"status"})"), nullptr, false);
  }
  EXPECT_EQ(ask(R"({"verb":"label","label":"sweep 3, dry"})"), "{\"done\":true}\n");
  EXPECT_EQ(ask(R"({"verb":"stop","comment":"enough"})"), "{\"done\":true}\n");
  kill(child, SIGTERM);
  EXPECT_EQ(wait_for_end(), 0) << read("output");

  std::map<std::int64_t, std::string> files;  // by number of the run
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/runs"))
    if (entry.path().extension() == ".dwell") {
      const auto run = record::RunReader::open(entry.path());
      ASSERT_TRUE(run) << run.error();
      files[run->header().run] = entry.path();
    }
  ASSERT_EQ(files.size(), 2u) << read("dwelld.log");
  const auto drives = record::RunReader::open(files[1]), operators = record::RunReader::open(files[2]);
  ASSERT_TRUE(drives && operators);
  EXPECT_EQ(drives->header().begun_by, "drive");
  ASSERT_TRUE(drives->end() && operators->end());
  EXPECT_EQ(drives->end()->why, "operator");
  EXPECT_EQ(operators->header().begun_by, "operator");
  EXPECT_EQ(operators->header().label, "sweep 3, dry");
  EXPECT_EQ(operators->header().comment, "new damper");
  ASSERT_TRUE(operators->header().person);
  EXPECT_EQ(operators->header().person->uid, getuid());
  EXPECT_EQ(operators->header().rig.text, text);
  for (const auto& [run, file] : files) {
    const auto audited = record::audit_run(file, {});
    ASSERT_TRUE(audited) << audited.error();
    EXPECT_EQ(audited->state, record::AuditState::intact) << audited->where;
  }
}

TEST_F(ProcessTest, IsReadyThoughTheRigIsOffAndStopsThenAsWell) {
  std::uint16_t nobody = 0;
  {
    auto rig = rigsim::Server::start(test::clamped_rig());
    ASSERT_TRUE(rig);
    nobody = (*rig)->tcp_port();
  }
  start({"--config", write("rig.toml", test::rig_file(nobody))});
  ASSERT_TRUE(notified("READY=1")) << read("output");
  EXPECT_TRUE(notified("STATUS=fault")) << "the state is told";
  EXPECT_TRUE(notified("WATCHDOG=1")) << "a rig that is off is no reason to be restarted";
  kill(child, SIGINT);
  EXPECT_EQ(wait_for_end(), 0) << read("output");
}

TEST_F(ProcessTest, ChecksARigFileAndTellsEveryMistakeWithItsPlace) {
  EXPECT_EQ(run({"--check-config", write("rig.toml", test::rig_file(1502))}), 0) << read("output");
  EXPECT_NE(read("output").find("5 channels"), std::string::npos) << read("output");

  std::string wrong = test::rig_file(1502);
  wrong.replace(wrong.find("clamped"), 7, "clamped?");
  wrong.replace(wrong.find("rate "), 5, "rat  ");
  EXPECT_EQ(run({"--check-config", write("wrong.toml", wrong)}), 2);
  const std::string output = read("output");
  EXPECT_NE(output.find("wrong.toml:4:"), std::string::npos) << output;
  EXPECT_NE(output.find("rat"), std::string::npos) << output;
  EXPECT_EQ(run({"--config", folder + "/wrong.toml"}), 2) << "and does not serve it";
}

TEST_F(ProcessTest, TheCheckWarnsOfRatesThatFoldHarmonicsAndOfAnAddressThatIsNone) {
  std::string text = test::rig_file(1502);
  const std::size_t at = text.find("rate");
  text.replace(at, text.find('\n', at) - at, "rate = 40\nrate_shift = false");
  EXPECT_EQ(run({"--check-config", write("folds.toml", text)}), 0) << read("output");
  EXPECT_NE(read("output").find("harmonic"), std::string::npos) << read("output");

  std::string nowhere = test::rig_file(1502);
  nowhere.replace(nowhere.find("127.0.0.1:0"), 11, "host:port");
  const std::string path = write("nowhere.toml", nowhere);
  for (const char* option : {"--check-config", "--config"}) {
    EXPECT_EQ(run({option, path}), 2) << option;
    EXPECT_NE(read("output").find("nowhere.toml:10:10: \"listen\""), std::string::npos) << read("output");
  }
}

TEST_F(ProcessTest, ANetworkThatNobodyGuardsIsRefusedByTheCheckAndAtTheStart) {
  std::string open = test::rig_file(1502);
  open.replace(open.find("127.0.0.1:0"), 11, "0.0.0.0:0");
  const std::string path = write("open.toml", open);
  for (const char* option : {"--check-config", "--config"}) {
    EXPECT_EQ(run({option, path}), 2) << option;
    EXPECT_NE(read("output").find("open.toml:10:10: \"listen\" is \"0.0.0.0:0\""), std::string::npos) << read("output");
  }
  open.replace(open.find("[[device]]"), 0, "token_file = \"token\"\n");
  write("open.toml", open);
  EXPECT_EQ(run({"--check-config", path}), 2);
  EXPECT_NE(read("output").find("open.toml:11:14: token_file"), std::string::npos) << read("output");
  write("token", std::string(32, 'x'));
  std::filesystem::permissions(folder + "/token", std::filesystem::perms::owner_read);
  EXPECT_EQ(run({"--check-config", path}), 0) << read("output");
}

TEST_F(ProcessTest, LampsOffNeedsNoDriverAndSaysWhichLampItCouldNotReach) {
  std::string text = test::rig_file(1502);
  text.replace(text.find("\"modbus\""), 8, "\"no-such\"");
  EXPECT_EQ(run({"--lamps-off", "--config", write("rig.toml", text)}), 0)
      << "no lamp, nothing to do: " << read("output");
  text += "[gpio]\nready = { chip = \"/dev/no-such-gpiochip\", line = 1 }\n";
  EXPECT_EQ(run({"--lamps-off", "--config", write("rig.toml", text)}), 1);
  EXPECT_NE(read("output").find("there is no /dev/no-such-gpiochip"), std::string::npos) << read("output");
  EXPECT_EQ(run({"--lamps-off"}), 2);
}

TEST_F(ProcessTest, WrongUsageIsTwo) {
  EXPECT_EQ(run({}), 2);
  EXPECT_EQ(run({"--no-such-option"}), 2);
  EXPECT_EQ(run({"--config"}), 2);
  EXPECT_EQ(run({"--config", folder + "/not-there.toml"}), 2);
  EXPECT_EQ(run({"--version"}), 0);
  EXPECT_NE(read("output").find("dwelld "), std::string::npos);
}

TEST_F(ProcessTest, AnAddressInUseIsOneWithAClearMessage) {
  const int taken = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ASSERT_EQ(bind(taken, reinterpret_cast<const sockaddr*>(&address), size), 0);
  ASSERT_EQ(listen(taken, 1), 0);
  getsockname(taken, reinterpret_cast<sockaddr*>(&address), &size);
  std::string text = test::rig_file(1502);
  const std::string any = "127.0.0.1:0";
  text.replace(text.find(any), any.size(), "127.0.0.1:" + std::to_string(ntohs(address.sin_port)));
  EXPECT_EQ(run({"--config", write("rig.toml", text)}), 1);
  EXPECT_NE(read("output").find("cannot listen on 127.0.0.1:"), std::string::npos) << read("output");
  close(taken);
}

TEST_F(ProcessTest, AHangupChecksTheRigFileAndEndsNothing) {
  auto rig = rigsim::Server::start(test::clamped_rig());
  ASSERT_TRUE(rig);
  const std::string text = test::rig_file((*rig)->tcp_port());
  start({"--config", write("rig.toml", text)});
  ASSERT_TRUE(notified("READY=1")) << read("output");
  kill(child, SIGHUP);
  ASSERT_TRUE(said("rig.toml is what is being served")) << read("output");
  write("rig.toml", text + "# another line\n");
  kill(child, SIGHUP);
  EXPECT_TRUE(said("rig.toml has changed and holds no mistake")) << read("output");
  EXPECT_TRUE(said("restart the service")) << read("output");
  write("rig.toml", text + "[nonsense]\n");
  kill(child, SIGHUP);
  EXPECT_TRUE(said("unknown key \"nonsense\"")) << read("output");
  kill(child, SIGTERM);
  EXPECT_EQ(wait_for_end(), 0) << read("output");
}

TEST_F(ProcessTest, AnAddressThatIsNotUpYetIsWaitedForWhileTheRigIsMeasured) {
  auto rig = rigsim::Server::start(test::clamped_rig());
  ASSERT_TRUE(rig);
  std::vector<std::string> addresses{"192.0.2.1:0"};  // of documentation, on no host
  if (const int probe = socket(AF_INET6, SOCK_STREAM | SOCK_CLOEXEC, 0); probe >= 0) {
    close(probe);
    addresses.emplace_back("[2001:db8::1]:0");
  }
  for (const std::string& address : addresses) {
    std::string text = test::rig_file((*rig)->tcp_port());
    const std::string any = "127.0.0.1:0";
    text.replace(text.find(any) - 1, any.size() + 2, "\"" + address + "\"\nbehind_proxy = true");
    notifications.clear();
    start({"--config", write("rig.toml", text)});
    ASSERT_TRUE(notified("READY=1")) << read("output");
    EXPECT_TRUE(said("listen: " + address + " is no address of this computer yet")) << read("output");
    EXPECT_TRUE(notified("STATUS=settling")) << read("output");
    kill(child, SIGTERM);
    EXPECT_EQ(wait_for_end(), 0) << read("output");
  }
}

TEST_F(ProcessTest, AnAddressThatIsNoneIsTwo) {
  std::string text = test::rig_file(1502);
  const std::string any = "127.0.0.1:0";
  text.replace(text.find(any), any.size(), "bench.local:8380");
  EXPECT_EQ(run({"--config", write("rig.toml", text)}), 2) << read("output");
}

}  // namespace
}  // namespace dwell
