// The whole service on a simulated rig, in this process: sockets, threads, plugin and all.
#include "daemon/service.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <optional>

#include "daemon/acquire/plugin.hpp"
#include "tests/api_schema.hpp"
#include "tests/daemon/service_rig.hpp"

namespace dwell {
namespace {

using nlohmann::json;
using test::await;
using test::get_json;

const config::SchemaSource kDrivers = [](std::string_view name) {
  return acquire::load_plugin(std::string(name), {DWELL_TEST_PLUGINS});
};

struct ServiceTest : testing::Test {
  ServiceTest() {
    LogOptions quiet;
    quiet.console = false;
    log = std::move(*Log::make(quiet));
  }
  ~ServiceTest() override {
    if (service) service->stop();
    if (thread.joinable()) thread.join();
  }
  void start_rig(std::uint16_t device_port = 0) {
    auto started = rigsim::Server::start(test::clamped_rig(device_port));
    ASSERT_TRUE(started) << started.error();
    rig = std::move(*started);
  }
  void start_service(std::uint16_t device_port, const std::string& more = {}) {
    auto file = config::parse(test::rig_file(device_port) + more, "rig.toml", kDrivers);
    ASSERT_TRUE(file) << config::to_string("rig.toml", file.error());
    ServiceOptions options;
    options.handle_signals = false;
    auto made = Service::make(std::move(*file), kDrivers, options, *log);
    ASSERT_TRUE(made) << made.error().message;
    service = std::move(*made);
    port = service->port();
    thread = std::thread([this] { service->run(); });
  }
  // Measuring, with some seconds of data behind it.
  json await_measured() {
    return await(port, "/api/v1/dwell", [](const json& dwell) {
      return dwell["state"] == "measuring" && dwell["end_s"].get<double>() - dwell["settled_s"].get<double>() > 3.0;
    });
  }

  std::unique_ptr<Log> log;
  std::unique_ptr<rigsim::Server> rig;
  std::unique_ptr<Service> service;
  std::thread thread;
  std::uint16_t port = 0;
};

// Truth of rigsim's default chain.
void expect_truth(const json& dwell) {
  const double stiffness[] = {24000.0, 8000.0, 6000.0, 8000.0};
  const double damping[] = {60.0, 45.0, 30.0, 40.0};
  ASSERT_EQ(dwell["elements"].size(), 4u) << dwell.dump(1);
  for (std::size_t k = 0; k < 4; ++k) {
    const json& element = dwell["elements"][k];
    ASSERT_TRUE(element["identifiable"].get<bool>()) << element.dump(1);
    const double c = element["stiffness"]["value"];
    const double r = element["damping"]["value"];
    EXPECT_LT(std::fabs(c - stiffness[k]), 4.0 * element["stiffness"]["u"].get<double>()) << "c_" << k + 1 << " " << c;
    EXPECT_LT(std::fabs(r - damping[k]), 4.0 * element["damping"]["u"].get<double>()) << "r_" << k + 1 << " " << r;
  }
}

TEST_F(ServiceTest, MeasuresARigOverModbusWithinItsOwnUncertainty) {
  start_rig();
  start_service(rig->tcp_port());
  expect_truth(await_measured());
  const json channels = get_json(port, "/api/v1/channels");
  for (const json& channel : channels["channels"]) {
    EXPECT_EQ(channel["received"].get<long>(),
              channel["used"].get<long>() + channel["dropped"].get<long>() + channel["queued"].get<long>());
    EXPECT_GT(channel["used"].get<long>(), 0);
  }
  EXPECT_EQ(get_json(port, "/api/v1/health")["status"], "ok");
  const test::ApiSchema schema;
  for (const char* name : {"dwell", "dwells", "channels", "health"})
    EXPECT_EQ(schema.faults(name, get_json(port, std::string("/api/v1/") + name)), "");
}

// Of the log: "serving PLCs on 127.0.0.1 port 40123; …".
std::uint16_t plc_port(const Log& log) {
  const std::string before = "serving PLCs on 127.0.0.1 port ";
  for (const LogLine& line : log.newest().newest(NewestLines::kLines))
    if (line.text.compare(0, before.size(), before) == 0)
      return static_cast<std::uint16_t>(std::stoi(line.text.substr(before.size())));
  return 0;
}

// Register `at` of an answer to a read of registers 0 … 124, as one word or as a float32.
std::uint16_t word_of(const std::string& answer, std::size_t at) {
  const auto byte = [&answer](std::size_t i) { return static_cast<unsigned>(static_cast<unsigned char>(answer[i])); };
  return static_cast<std::uint16_t>(byte(9 + 2 * at) << 8U | byte(10 + 2 * at));
}
float real_of(const std::string& answer, std::size_t at) {
  return std::bit_cast<float>(static_cast<std::uint32_t>(word_of(answer, at)) << 16U | word_of(answer, at + 1));
}

TEST_F(ServiceTest, PlcsReadTheCoefficientsAndLoseThemWithTheRig) {
  start_rig();
  start_service(rig->tcp_port(), "[modbus_server]\nlisten = \"127.0.0.1:0\"\n");
  const double c_1 = await_measured()["elements"][0]["stiffness"]["value"];
  test::Client plc = test::Client::tcp(plc_port(*log));
  const auto page = [&plc] {
    plc.send({"\x00\x01\x00\x00\x00\x06\x01\x04\x00\x00\x00\x7d", 12});
    return plc.exactly(259);
  };
  const std::string measured = page();
  ASSERT_EQ(measured.size(), 259U);
  EXPECT_EQ(word_of(measured, 3), 2) << "measuring";
  EXPECT_EQ(word_of(measured, 24), 1) << "valid";
  EXPECT_NEAR(real_of(measured, 26), c_1, 1e-2 * c_1);
  EXPECT_GT(real_of(measured, 28), 0.0F);

  rig.reset();
  await(port, "/api/v1/channels", [](const json& a) { return !test::all_channels(a, "ok"); });
  await(port, "/api/v1/dwell", [](const json& dwell) {
    for (const json& element : dwell["elements"])
      if (element["identifiable"].get<bool>()) return false;
    return true;
  });
  // The image is of the snapshot before that answer at the oldest.
  std::string lost = page();
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (lost.size() == 259U && !std::isnan(real_of(lost, 26)) && std::chrono::steady_clock::now() < until)
    lost = page();
  ASSERT_EQ(lost.size(), 259U);
  EXPECT_TRUE(std::isnan(real_of(lost, 26)));
  EXPECT_NE(word_of(lost, 24), 1);
  EXPECT_EQ(word_of(lost, 5), 0) << "not ready";
  const json health = get_json(port, "/api/v1/health");
  EXPECT_GT(health["modbus"]["answers"].get<int>(), 1);
  EXPECT_EQ(test::ApiSchema().faults("health", health), "");
}

// The harmonic verdict of this rig takes ten minutes, longer than the slowest machine takes to estimate. Its transient
// tells the chain in seconds, on the thread for long work.
TEST_F(ServiceTest, ShowsCoefficientsFromTheTransientLongBeforeTheVerdict) {
  rigsim::Options options = test::clamped_rig();
  for (double& damping : options.chain.damping) damping *= 0.003;
  auto started = rigsim::Server::start(options);
  ASSERT_TRUE(started) << started.error();
  rig = std::move(*started);
  start_service(rig->tcp_port());
  EXPECT_EQ(get_json(port, "/api/v1/verification")["verdict"], "not verified yet");
  const json dwell = await(port, "/api/v1/dwell", [](const json& now) { return now["motion"].is_object(); });
  EXPECT_EQ(dwell["state"], "settling");
  EXPECT_TRUE(dwell["elements"].empty());
  EXPECT_EQ(test::ApiSchema().faults("dwell", dwell), "");
  ASSERT_EQ(dwell["motion"]["elements"].size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    const json& element = dwell["motion"]["elements"][k];
    if (!element["identifiable"].get<bool>()) continue;  // on a slow machine the first stretch may not determine it
    EXPECT_NEAR(element["stiffness"]["value"].get<double>(), options.chain.stiffness[k],
                std::max(0.02 * options.chain.stiffness[k], 4.0 * element["stiffness"]["u"].get<double>()));
  }
}

TEST_F(ServiceTest, VerifiesTheModelOfWhatItMeasures) {
  start_rig();
  start_service(rig->tcp_port());
  const json seen = await(port, "/api/v1/verification", [](const json& now) { return now["dwell"] == 1; });
  EXPECT_EQ(test::ApiSchema().faults("verification", seen), "");
  EXPECT_NE(seen["verdict"], "not adequate") << seen.dump(1);
  const json dwell = await(port, "/api/v1/dwell", [](const json& now) { return now["model"].is_object(); });
  EXPECT_EQ(dwell["model"]["asked"], 0.05);
}

TEST_F(ServiceTest, ARigThatGoesAndComesBackIsAStateNotAFailure) {
  start_rig();
  const std::uint16_t device_port = rig->tcp_port();
  start_service(device_port);
  await_measured();

  rig.reset();
  const json stale = await(port, "/api/v1/channels", [](const json& answer) {
    for (const json& channel : answer["channels"])
      if (channel["status"] == "ok") return false;
    return true;
  });
  for (const json& channel : stale["channels"]) {
    EXPECT_NE(channel["status"], "ok");
    EXPECT_TRUE(channel["reason"].is_string()) << channel.dump();
  }
  const json withdrawn = await(port, "/api/v1/dwell", [](const json& dwell) { return dwell["state"] != "measuring"; });
  for (const json& element : withdrawn["elements"]) EXPECT_FALSE(element["identifiable"].get<bool>()) << element.dump();
  EXPECT_FALSE(withdrawn["warnings"].empty()) << withdrawn.dump(1);
  const json health = get_json(port, "/api/v1/health");
  EXPECT_EQ(health["status"], "degraded");
  EXPECT_EQ(health["stale"].size(), 5u);
  EXPECT_FALSE(health["devices"][0]["up"].get<bool>());

  start_rig(device_port);
  await(port, "/api/v1/channels", [](const json& answer) { return test::all_channels(answer, "ok"); });
  const json again = await_measured();
  expect_truth(again);
  EXPECT_GT(again["index"], 1);
  const json finished = get_json(port, "/api/v1/dwells");
  ASSERT_GE(finished["dwells"].size(), 1u);
  EXPECT_EQ(finished["dwells"][0]["ended_by"], "data lost") << finished.dump(1);
}

TEST_F(ServiceTest, IsUpThoughTheRigWasNeverThere) {
  start_rig();
  const std::uint16_t nobody = rig->tcp_port();
  rig.reset();
  start_service(nobody);
  const json health = await(port, "/api/v1/health", [](const json& answer) {
    return answer["devices"].size() == 1 && answer["devices"][0]["faults"].contains("disconnected");
  });
  EXPECT_EQ(health["status"], "degraded");
  const json channels =
      await(port, "/api/v1/channels", [](const json& answer) { return test::all_channels(answer, "disconnected"); });
  EXPECT_TRUE(channels["channels"][0]["value"].is_null());
}

TEST_F(ServiceTest, PushesTheDwellToWhoeverListens) {
  start_rig();
  start_service(rig->tcp_port());
  test::Client client = test::Client::tcp(port);
  client.send("GET /api/v1/stream HTTP/1.1\r\nHost: localhost\r\n\r\n");
  client.until("\r\n\r\n");
  EXPECT_EQ(client.until("\n\n"), "retry: 1000\n\n");
  int whole = 0, changes = 0;
  for (int i = 0; i < 25; ++i) {
    const std::string event = client.until("\n\n");
    const auto data = event.find("\ndata: ");
    ASSERT_NE(data, std::string::npos) << event;
    const std::string name = event.substr(0, data);
    ASSERT_TRUE(name == "event: dwell" || name == "event: change") << event;
    (name == "event: dwell" ? whole : changes)++;
    EXPECT_TRUE(i > 0 || whole == 1) << "a newcomer is given all";
    const json told = json::parse(event.substr(data + 7), nullptr, false);
    EXPECT_TRUE(told.contains("state") && told.contains("index")) << event;
  }
  EXPECT_GE(whole, 2) << "at the first, and again";
  EXPECT_GE(changes, 1);
}

}  // namespace
}  // namespace dwell
