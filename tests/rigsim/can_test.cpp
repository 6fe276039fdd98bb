// The rig on a CAN bus: frames that the DBC file it prints makes sense of, and each fault doing what its name says.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

#include "drivers/can/dbc.hpp"
#include "drivers/can/decoder.hpp"
#include "drivers/socketcan/bus.hpp"
#include "tests/rigsim/can_frames.hpp"
#include "tests/rigsim/rig_fixture.hpp"

namespace rigsim {
namespace {

using namespace test;
using dwell::socketcan::Bus;

class CanRig : public Rig {
 protected:
  CanRig() {
    options.tcp_port.reset();
    options.can =
        "unix:" + (std::filesystem::temp_directory_path() / ("rigsim-can-" + std::to_string(::getpid()))).string();
    options.can_rate_hz = 1000;
    for (const char* name : {"Motion0", "Motion1", "Motion2", "Motion3", "LoadCell"}) names_.emplace_back(name);
  }
  void start() {
    Rig::start();
    ASSERT_EQ(bus_.open(), "");
    const auto dbc = dwell::can::parse_dbc(can_dbc({"y0", "y1", "y2", "y3", "reaction"}, true, 1.0));
    ASSERT_TRUE(dbc);
    std::vector<dwell::can::Wanted> wanted;
    for (const std::string& name : names_) {
      for (const auto& message : dbc->messages) {
        if (message.name != name) continue;
        for (const auto& signal : message.signals) {
          if (signal.name != "Position" && signal.name != "Force") continue;
          wanted.push_back({{message.id, message.extended, message.j1939, -1}, signal.field, signal.factor, 0.0, {}});
          if (signal.multiplexed)
            wanted.back().conditions.push_back({message.signals[signal.selector].field, signal.selected_by});
        }
      }
    }
    ASSERT_EQ(wanted.size(), names_.size());
    decoder_.emplace(std::move(wanted));
  }
  // Takes frames until `condition`.
  void listen(const std::function<bool()>& condition) {
    await([&] {
      const auto receipt = bus_.read();
      errors_ += receipt.errors;
      bus_off_ = bus_off_ || receipt.bus_off;
      for (const auto& frame : receipt.frames) {
        ++frames_;
        if (frame.can.can_id == 0) ++babbled_;
        for (const auto& reading : decoder_->decode(frame.can)) {
          ++verdicts_[reading.verdict];
          if (reading.verdict == dwell::can::Verdict::value) last_[reading.wanted] = reading.value;
        }
      }
      return condition();
    });
  }

  std::vector<std::string> names_;
  Bus bus_{"bus", [this] { return dwell::socketcan::open_socket(options.can, {}); }};
  std::optional<dwell::can::Decoder> decoder_;
  std::map<std::size_t, double> last_;
  std::map<dwell::can::Verdict, int> verdicts_;
  int frames_ = 0, babbled_ = 0;
  unsigned errors_ = 0;
  bool bus_off_ = false;
};

TEST_F(CanRig, SendsTheModelAsItsDbcFileSays) {
  start();
  for (const double t_s : {0.1, 1.2345}) {
    set_time(t_s);
    const auto expected = truth(t_s);
    const auto sends = [&](std::size_t k, double value, double within) { return std::abs(last_[k] - value) <= within; };
    // Frames that were on the way when the time was set hold older values.
    listen([&] {
      bool all = sends(4, expected[4], 1e-5);
      for (std::size_t k = 0; k < 4; ++k) all = all && sends(k, 1e3 * expected[k], 2e-6);
      return all;
    });
    const int before = frames_;
    listen([&] { return frames_ > before + 20; });
    ASSERT_EQ(last_.size(), 5U);
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(last_[k], 1e3 * expected[k], 2e-6) << k;
    EXPECT_NEAR(last_[4], expected[4], 1e-5);
  }
}

TEST_F(CanRig, IsWhatTheSampleRigsDbcFileSays) {
  std::ifstream file(DWELL_SAMPLE_RIGS "/rigsim.dbc");
  const std::string shipped{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(shipped, can_dbc({"y0", "y1", "y2", "y3", "reaction"}, true, 5.0));
}

TEST_F(CanRig, LosesFramesAndSendsThemShort) {
  options.faults.short_frame = 0.5;
  start();
  listen([&] { return verdicts_[dwell::can::Verdict::short_frame] > 10; });
  ok("missing 1");
  const std::string before = server->command("status");
  await([&] { return server->command("status").find("\"frames_lost\":0") == std::string::npos; });
  EXPECT_NE(before.find("\"frames\":"), std::string::npos);
}

TEST_F(CanRig, Babbles) {
  options.faults.babble_hz = 5000;
  start();
  listen([&] { return babbled_ > 500 && last_.size() == 5; });
}

TEST_F(CanRig, FallsSilentAtBusOffUntilRestarted) {
  start();
  listen([&] { return frames_ > 10; });
  ok("bus-off");
  listen([&] { return bus_off_; });
  const int then = frames_;
  ok("restart");
  listen([&] { return frames_ > then + 10; });
  ok("error-passive");
  listen([&] { return bus_.controller() == dwell::socketcan::Controller::passive; });
}

TEST_F(CanRig, LeavesAndComesBack) {
  start();
  listen([&] { return frames_ > 10; });
  ok("can off");
  await([&] { return bus_.read().error == ECONNRESET; });
  EXPECT_NE(bus_.open(), "");
  ok("can on");
  EXPECT_EQ(bus_.open(), "");
  const int then = frames_;
  listen([&] { return frames_ > then + 10; });
}

}  // namespace
}  // namespace rigsim
