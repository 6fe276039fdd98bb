// What the whole service leaves in the file of a run, on a simulated rig that is gone at the end.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/acquire/plugin.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/service.hpp"
#include "tests/daemon/service_rig.hpp"
#include "tests/durations.hpp"
#include "tests/record/scratch.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell {
namespace {

constexpr double kEvery_s = 2.0;

tl::expected<std::unique_ptr<Service>, Service::Failure> service_of(const std::string& rig_file, Log& log,
                                                                    ServiceOptions options) {
  const config::SchemaSource drivers = [](std::string_view name) {
    return acquire::load_plugin(std::string(name), {DWELL_TEST_PLUGINS});
  };
  auto file = config::parse(rig_file, "rig.toml", drivers);
  if (!file) return tl::unexpected(Service::Failure{2, config::to_string("rig.toml", file.error())});
  options.handle_signals = false;
  return Service::make(std::move(*file), drivers, options, log);
}

std::unique_ptr<Log> quiet_log() {
  LogOptions quiet;
  quiet.console = false;
  return std::move(*Log::make(quiet));
}

// Played once for all tests: measured for six seconds, then the rig's plug is pulled.
struct RecordedService : testing::Test {
  static void SetUpTestSuite() {
    auto rig = rigsim::Server::start(test::clamped_rig());
    ASSERT_TRUE(rig) << rig.error();
    const auto log = quiet_log();
    auto service = service_of(
        test::rig_file((*rig)->tcp_port()) + "[recording]\ndirectory = \"" + scratch().path() + "\"\nevery = 2.0\n",
        *log, {});
    ASSERT_TRUE(service) << service.error().message;
    std::thread thread([&] { (*service)->run(); });
    const auto dwell = [&](const auto& enough) { return test::await((*service)->port(), "/api/v1/dwell", enough); };
    dwell([](const nlohmann::json& now) {
      return now["state"] == "measuring" && now["end_s"].get<double>() - now["settled_s"].get<double>() > 6.0;
    });
    rig->reset();
    dwell([](const nlohmann::json& now) { return now["state"] != "measuring"; });
    (*service)->stop();
    thread.join();
  }
  static void TearDownTestSuite() { delete std::exchange(scratch_, nullptr); }

  static std::string first_file() {
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(scratch().path()))
      if (entry.path().extension() == ".dwell") files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());  // the first run's is the one that the drive began
    return files.at(0);
  }
  static record::RunReader read() {
    auto reader = record::RunReader::open(first_file());
    EXPECT_TRUE(reader) << reader.error();
    return std::move(reader.value());
  }

  static record::Scratch& scratch() {
    if (scratch_ == nullptr) scratch_ = new record::Scratch;
    return *scratch_;
  }
  static record::Scratch* scratch_;
};
record::Scratch* RecordedService::scratch_ = nullptr;

TEST_F(RecordedService, ItsRunFileHoldsEachChangeOfStateWithItsReason) {
  std::vector<std::string> states;
  ASSERT_TRUE(read().events([&](const record::StoredEvent& event) {
    if (event.what != "state") return true;
    EXPECT_GT(event.position, 0u) << event.text;
    EXPECT_EQ(event.utc.size(), 27u) << event.text;
    states.push_back(event.text);
    return true;
  }));
  const auto reason_of = [&](const std::string& change) {
    for (const std::string& state : states)
      if (state.compare(0, change.size(), change) == 0) return state.substr(change.size());
    return std::string("no such change");
  };
  EXPECT_NE(reason_of("state settling -> measuring, dwell 1: ").find("oscillations are below"), std::string::npos)
      << testing::PrintToString(states);
  EXPECT_NE(reason_of("state measuring -> fault: ").find("disconnected"), std::string::npos)
      << testing::PrintToString(states);
}

TEST_F(RecordedService, ItsRunFileIsReadByTheIndependentReader) {
  if (std::system("/usr/bin/python3 -c 'import zstandard, cryptography' 2>/dev/null") != 0)
    GTEST_SKIP() << "python3-zstandard or python3-cryptography is not installed";
  record::RunReader reader = read();
  const std::string said = scratch().path("said");
  const std::string command = "/usr/bin/python3 " DWELL_SOURCE "/tests/record/read_run_file.py " + first_file() +
                              " --key " + reader.header().vkey + " >" + said;
  EXPECT_EQ(std::system(command.c_str()), 0);
  const nlohmann::json found = nlohmann::json::parse(record::Scratch::read(said), nullptr, false);
  EXPECT_EQ(found["state"], "intact") << found["where"];
  ASSERT_TRUE(reader.end());
  EXPECT_EQ(found["records"], reader.end()->records);
  EXPECT_EQ(found["samples"], reader.end()->samples);
  EXPECT_EQ(found["run"]["rig"]["text"], reader.header().rig.text);
  std::vector<std::uint64_t> positions, found_positions;
  ASSERT_TRUE(reader.results(
      false, [&](const record::StoredResult& result) { return positions.push_back(result.position), true; }));
  for (const auto& result : found["results"]) found_positions.push_back(result["position"]);
  EXPECT_GT(positions.size(), 3u);
  EXPECT_EQ(found_positions, positions);
}

// What the threads for long work published, each at its own time.
TEST_F(RecordedService, ItsEstimatesAndVerificationsAreComputedAgainToTheBit) {
  const std::string said = scratch().path("replayed");
  EXPECT_EQ(std::system((DWELLCTL " replay --models --json " + first_file() + " >" + said).c_str()), 0);
  const nlohmann::json found = nlohmann::json::parse(record::Scratch::read(said), nullptr, false);
  EXPECT_EQ(found["identical"], true) << found["differences"];
  int estimates = 0, verifications = 0;
  ASSERT_TRUE(read().models([&](const record::StoredModel& model) {
    return ++(model.kind == "estimate" ? estimates : verifications), true;
  }));
  EXPECT_EQ(found["compared"]["estimates"], estimates);
  EXPECT_EQ(found["compared"]["verifications"], verifications);
  // ThreadSanitizer looks at the threads above; it slows them so that the run may end before the first of them is done.
  if (kUnderThreadSanitizer) return;
  EXPECT_GT(estimates, 0);
  EXPECT_GT(verifications, 0);
}

TEST_F(RecordedService, ItsResultsOfADwellThatGoesOnAreAsFarApartAsTheRigFileAsks) {
  record::RunReader reader = read();
  std::vector<std::uint64_t> positions;
  ASSERT_TRUE(reader.results(false, [&](const record::StoredResult& result) {
    if (!result.final) positions.push_back(result.position);
    return true;
  }));
  ASSERT_GE(positions.size(), 3u);
  std::vector<std::int64_t> instants;
  std::uint64_t position = 0;
  ASSERT_TRUE(reader.stream([&](const Record& record) {
    ++position;
    for (const std::uint64_t asked : positions)
      if (asked == position) instants.push_back(record.t_ns);
    return true;
  }));
  ASSERT_EQ(instants.size(), positions.size());
  for (std::size_t i = 1; i < instants.size(); ++i)
    EXPECT_NEAR(1e-9 * static_cast<double>(instants[i] - instants[i - 1]), kEvery_s, 0.5) << i;
}

// What is in the way of a run may show only as its file is begun.
TEST(StartOfARun, IsAnsweredOnceItIsKnownWhetherItIsRecorded) {
  const record::Scratch scratch;
  std::filesystem::create_directory(scratch.path("runs"));
  constexpr std::uint16_t kNobody = 1;  // a port without a device: runs begin by the operator alone
  const auto log = quiet_log();
  ServiceOptions options;
  options.control_path = scratch.path("control");
  options.start_patience_ns = 600 * kSecond_ns;  // however slow the machine is
  auto service = service_of(test::rig_file(kNobody) + "[recording]\ndirectory = \"" + scratch.path("runs") + "\"\n",
                            *log, options);
  ASSERT_TRUE(service) << service.error().message;
  std::thread thread([&] { (*service)->run(); });
  const auto rests_with = [&](const char* next_file) {
    bool rests = false;
    test::await((*service)->port(), "/api/v1/health", [&](const nlohmann::json& health) {
      return rests =
                 health["recorder"]["reason"] == "no run goes on" && std::filesystem::exists(scratch.path(next_file));
    });
    EXPECT_TRUE(rests) << next_file;
  };
  test::Client client = test::Client::local(options.control_path);
  const auto ask = [&client](const std::string& request) {
    client.send(request + "\n");
    return nlohmann::json::parse(client.until("\n"), nullptr, false);
  };

  rests_with("runs/next-1.new");
  EXPECT_EQ(ask(R"({"verb":"start","label":"good"})"), nlohmann::json::parse(R"({"done":true})"));
  const nlohmann::json recorder = ask(R"({"verb":"status"})")["health"]["recorder"];
  EXPECT_EQ(recorder["recording"], true) << recorder;
  EXPECT_EQ(recorder["run"]["label"], "good") << recorder;
  EXPECT_EQ(ask(R"({"verb":"stop"})"), nlohmann::json::parse(R"({"done":true})"));

  rests_with("runs/next-2.new");
  std::filesystem::remove(scratch.path("runs/next-2.new"));
  const nlohmann::json refused = ask(R"({"verb":"start","label":"bad"})");
  ASSERT_TRUE(refused["error"].is_string()) << refused;
  const std::string why = refused["error"];
  EXPECT_EQ(why.find("the run was asked for and is not recorded: "), 0u) << why;
  EXPECT_NE(why.find("next-2.new: the file was removed while it was written"), std::string::npos) << why;
  (*service)->stop();
  thread.join();
}

}  // namespace
}  // namespace dwell
