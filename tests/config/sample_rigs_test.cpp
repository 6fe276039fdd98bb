// The rig files that ship: each loads without a mistake, and says what its comments say.
#include <dlfcn.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "tests/config/fake_drivers.hpp"

namespace dwell::config::testing {
namespace {

RigFile shipped(const std::string& name) {
  const std::string path = std::string(DWELL_SAMPLE_RIGS "/") + name;
  EXPECT_TRUE(load(path, nullptr)) << name << " does not load without its driver";
  Result<RigFile> file = load(path, fake_schemas());
  if (!file) ADD_FAILURE() << to_string(path, file.error());
  return file ? std::move(*file) : RigFile{};
}

TEST(SampleRigs, OfTheClampedChainIsTheSimulatorsDefault) {
  const RigFile file = shipped("clamped.toml");
  EXPECT_EQ(file.rig.boundary, Boundary::clamped);
  EXPECT_EQ(file.rig.masses, (std::vector<double>{12.0, 8.0, 5.0}));
  ASSERT_EQ(file.rig.channels.size(), 5u);
  const char* const names[] = {"y0", "y1", "y2", "y3", "reaction"};
  for (int i = 0; i < 5; ++i) {
    const Channel& channel = file.rig.channels[static_cast<std::size_t>(i)];
    EXPECT_EQ(channel.name, names[i]);
    EXPECT_EQ(channel.at, i < 4 ? i : kGround);
    for (const Entry& entry : file.devices[0].channels[static_cast<std::size_t>(i)].entries) {
      if (entry.key == "register") {
        EXPECT_EQ(std::get<std::int64_t>(entry.value), 2 * i);
      }
    }
  }
}

TEST(SampleRigs, OfTheSuspensionIsFreeAndHasASecondOpinion) {
  const RigFile file = shipped("suspension.toml");
  EXPECT_EQ(file.rig.boundary, Boundary::free);
  EXPECT_EQ(file.rig.mass_count(), 2);
  EXPECT_EQ(file.rig.channels[2].relative_to, 1);
  EXPECT_EQ(file.rig.channels[3].measures, Quantity::acceleration);
  EXPECT_EQ(file.rig.channels[4].measures, Quantity::auxiliary);
}

TEST(SampleRigs, OfTheShaftTurns) {
  const RigFile file = shipped("shaft.toml");
  EXPECT_EQ(file.rig.motion, Motion::rotation);
  EXPECT_EQ(file.rig.element_count(), 3);
}

TEST(SampleRigs, OfTheReplayIsOneElement) {
  const RigFile file = shipped("replay.toml");
  EXPECT_EQ(file.rig.mass_count(), 0);
  EXPECT_EQ(file.rig.element_count(), 1);
  EXPECT_EQ(file.devices[0].driver, "replay");
}

// The schemas of the plugins as built; they stay loaded, as in the service.
tl::expected<const dwell_driver_table*, std::string> built_plugin(std::string_view driver) {
  const std::string file = std::string(DWELL_BUILT_PLUGINS "/dwell-driver-").append(driver).append(".so");
  void* const plugin = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  void* const symbol = plugin == nullptr ? nullptr : ::dlsym(plugin, DWELL_DRIVER_SYMBOL);
  if (symbol == nullptr) return tl::make_unexpected(std::string("cannot load ") + file);
  return reinterpret_cast<dwell_driver_function>(symbol)();
}

TEST(SampleRigs, LoadWithTheShippedPlugins) {
  for (const char* driver : {"modbus", "replay", "can", "canopen"}) {
    const std::string file = std::string(DWELL_BUILT_PLUGINS "/dwell-driver-") + driver + ".so";
    if (!std::ifstream(file)) GTEST_SKIP() << "the plugin " << file << " is not built";
  }
  for (const char* name :
       {"clamped.toml", "suspension.toml", "shaft.toml", "replay.toml", "can.toml", "canopen.toml"}) {
    const std::string path = std::string(DWELL_SAMPLE_RIGS "/") + name;
    const Result<RigFile> file = load(path, built_plugin);
    EXPECT_TRUE(file) << (file ? "" : to_string(path, file.error()));
  }
}

// The names in the list "expected a, b, c" that answers an unknown key.
std::vector<std::string> known_keys(std::string_view anchor, const std::string& unknown, const SchemaSource& schemas) {
  const std::string answer = mistakes_in(edited(anchor, unknown).text, schemas);
  std::vector<std::string> names;
  const std::size_t at = answer.find(": expected ");
  EXPECT_NE(at, std::string::npos) << answer;
  if (at == std::string::npos) return names;
  std::istringstream list(answer.substr(at + 11));
  for (std::string name; list >> name;) names.push_back(name.substr(0, name.find(',')));
  return names;
}

TEST(Manual, NamesEveryKeyOfEveryTable) {
  std::ostringstream manual;
  manual << std::ifstream(DWELL_RIG_MANUAL).rdbuf();
  ASSERT_FALSE(manual.str().empty());
  const std::pair<const char*, const char*> anchors[] = {
      {"[rig]\n", "[rig]\nxxxxxxxxxx = 1\n"},
      {"[excitation]\n", "[excitation]\nxxxxxxxxxx = 1\n"},
      {"[settling]\n", "[settling]\nxxxxxxxxxx = 1\n"},
      {"[estimation]\n", "[estimation]\nxxxxxxxxxx = 1\n"},
      {"", "[verification]\nxxxxxxxxxx = 1\n"},
      {"[server]\n", "[server]\nxxxxxxxxxx = 1\n"},
      {"[recording]\n", "[recording]\nxxxxxxxxxx = 1\n"},
      {"directory = \"runs\"", "retain = { xxxxxxxxxx = 1 }"},
      {"directory = \"runs\"", "anchor = { file = \"f\", xxxxxxxxxx = 1 }"},
      {"", "[gpio]\nxxxxxxxxxx = 1\n"},
      {"", "[gpio]\nsync = { chip = \"c\", line = 1, xxxxxxxxxx = 1 }\n"},
      {"", "[[limit]]\nelement = 1\nstiffness = [1, 2]\nxxxxxxxxxx = 1\n"},
      {"port = 1502", "xxxxxxxxxx = 1"},
      {"register = 2", "register = 2\nxxxxxxxxxx = 1"},
      {"order = 2, hz = 250", "order = 2, hz = 250, xxxxxxxxxx = 1"},
      {"id = \"K-2231\"", "id = \"K-2231\", xxxxxxxxxx = 1"},
      {"[rig]\n", "xxxxxxxxxx = 1\n[rig]\n"},
  };
  std::size_t keys = 0;
  for (const auto& [anchor, unknown] : anchors) {
    for (const std::string& key : known_keys(anchor, unknown, fake_schemas())) {
      EXPECT_NE(manual.str().find("\n.B " + key + "\n"), std::string::npos) << "the manual has no entry for " << key;
      ++keys;
    }
  }
  EXPECT_GT(keys, 60u);
}

}  // namespace
}  // namespace dwell::config::testing
