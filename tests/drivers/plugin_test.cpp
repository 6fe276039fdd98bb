#include "daemon/acquire/plugin.hpp"

#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace dwell::acquire {
namespace {

namespace fs = std::filesystem;

class PluginLoader : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("dwell-plugins-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override {
    ::unsetenv("DWELL_DRIVER_PATH");
    fs::remove_all(folder_);
  }
  fs::path folder_;
};

TEST_F(PluginLoader, LoadsByName) {
  for (const char* name : {"modbus", "replay"}) {
    const auto table = load_plugin(name, {TEST_PLUGIN_DIR});
    ASSERT_TRUE(table) << table.error();
    EXPECT_STREQ((*table)->name, name);
    EXPECT_EQ((*table)->abi, DWELL_DRIVER_ABI);
    EXPECT_GT((*table)->key_count, 0U);
  }
}

TEST_F(PluginLoader, GivesTheSameTableTwice) {
  EXPECT_EQ(load_plugin("replay", {TEST_PLUGIN_DIR}).value(), load_plugin("replay", {TEST_PLUGIN_DIR}).value());
}

TEST_F(PluginLoader, SearchesTheGivenThenTheEnvironmentThenTheProgram) {
  ::setenv("DWELL_DRIVER_PATH", "/second:/third::/first", 1);
  const auto folders = plugin_folders({"/first"});
  ASSERT_GE(folders.size(), 4U);
  EXPECT_EQ(folders[0], "/first");
  EXPECT_EQ(folders[1], "/second");
  EXPECT_EQ(folders[2], "/third");
  EXPECT_EQ(folders[3], fs::read_symlink("/proc/self/exe").parent_path().string());
  EXPECT_EQ(std::count(folders.begin(), folders.end(), "/first"), 1);
}

TEST_F(PluginLoader, FindsWhatTheEnvironmentNames) {
  ::setenv("DWELL_DRIVER_PATH", TEST_PLUGIN_DIR, 1);
  EXPECT_TRUE(load_plugin("modbus"));
}

TEST_F(PluginLoader, SaysWhereItLookedAndWhatThereIs) {
  const std::string error = load_plugin("modbuss", {TEST_PLUGIN_DIR}).error();
  EXPECT_NE(error.find("driver `modbuss` does not exist in " TEST_PLUGIN_DIR), std::string::npos) << error;
  EXPECT_NE(error.find("modbus, replay"), std::string::npos) << error;
}

TEST_F(PluginLoader, NeverTakesANameForAPath) {
  for (const char* name : {"../modbus", "a/b", "", "Modbus", "mod bus", ".", "x\n"}) {
    const auto table = load_plugin(name, {TEST_PLUGIN_DIR});
    ASSERT_FALSE(table);
    EXPECT_NE(table.error().find("a-z, 0-9"), std::string::npos);
  }
}

TEST_F(PluginLoader, RefusesAFileThatIsNoPlugin) {
  std::ofstream(folder_ / "dwell-driver-text.so") << "not a shared object";
  const auto table = load_plugin("text", {folder_.string()});
  ASSERT_FALSE(table);
  EXPECT_NE(table.error().find("dwell-driver-text.so cannot be used"), std::string::npos) << table.error();
}

TEST_F(PluginLoader, RefusesAPluginThatCallsItselfOtherwise) {
  fs::copy(fs::path(TEST_PLUGIN_DIR) / "dwell-driver-replay.so", folder_ / "dwell-driver-other.so");
  const auto table = load_plugin("other", {folder_.string()});
  ASSERT_FALSE(table);
  EXPECT_NE(table.error().find("it calls itself `replay`"), std::string::npos) << table.error();
}

TEST_F(PluginLoader, RefusesAnotherInterfaceAShortTableAndAMissingFunction) {
  for (const auto& [name, why] :
       {std::pair{"old-abi", "version 999"}, std::pair{"short-table", "too short"},
        std::pair{"no-stop", "a function is missing"}, std::pair{"no-table", "no table"},
        std::pair{"no-symbol", "does not export"}, std::pair{"short-keys", "its keys cannot be of 8 bytes each"}}) {
    const auto table = load_plugin(name, {TEST_BAD_PLUGIN_DIR});
    ASSERT_FALSE(table) << name;
    EXPECT_NE(table.error().find(why), std::string::npos) << table.error();
  }
}

TEST_F(PluginLoader, ListsTheNamesOfWhatItWouldLoad) {
  std::ofstream(folder_ / "dwell-driver-.so") << "";
  std::ofstream(folder_ / "dwell-driver-UPPER.so") << "";
  std::ofstream(folder_ / "dwell-driver-mine.so") << "";
  const auto names = plugin_names({folder_.string()});
  EXPECT_EQ(std::count(names.begin(), names.end(), "mine"), 1);
  EXPECT_EQ(std::count(names.begin(), names.end(), "UPPER"), 0);
  EXPECT_EQ(std::count(names.begin(), names.end(), ""), 0);
}

}  // namespace
}  // namespace dwell::acquire
