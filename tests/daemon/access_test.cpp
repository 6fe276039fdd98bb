// What the rig file says of who may read and change, and the file of the token.
#include <grp.h>
#include <gtest/gtest.h>
#include <pwd.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "daemon/serve/rights.hpp"

namespace dwell {
namespace {

constexpr const char* kFileToken = "0123456789abcdef0123456789abcdef";

struct AccessTest : testing::Test {
  void SetUp() override {
    char name[] = "/tmp/dwell-access-XXXXXX";
    ASSERT_NE(mkdtemp(name), nullptr);
    folder = name;
  }
  void TearDown() override { std::filesystem::remove_all(folder); }

  std::string write(const std::string& text, mode_t mode = 0640) {
    const std::string path = folder + "/token";
    std::ofstream(path) << text;
    chmod(path.c_str(), mode);
    return path;
  }
  // Why the file cannot be used; empty: it can.
  std::string fault(const std::string& text, mode_t mode = 0640) {
    const auto token = Token::read(write(text, mode));
    return token ? "" : token.error();
  }
  // With these tables behind all that a rig file needs.
  [[nodiscard]] config::RigFile rig_file(const std::string& tables) const {
    auto file = config::parse(
        "[rig]\nname = \"r\"\nboundary = \"clamped\"\nmasses = []\n[excitation]\nfrequency = 4.0\nminimum = 2e-5\n"
        "[[channel]]\nname = \"y0\"\nmeasures = \"displacement\"\nat = 0\nunit = \"m\"\n"
        "[[channel]]\nname = \"f\"\nmeasures = \"force\"\nat = \"ground\"\nunit = \"N\"\n" +
            tables,
        folder + "/rig.toml", {});
    if (file) return std::move(*file);
    ADD_FAILURE() << config::to_string("rig.toml", file.error());
    return {};
  }
  // Of a rig file with this [server].
  config::Result<Access> access(const std::string& keys) { return read_access(rig_file("[server]\n" + keys).server); }
  // The mistake in it, with its place.
  std::string mistake(const std::string& keys) {
    const auto read = access(keys);
    return read ? "" : config::to_string("rig.toml", read.error().front());
  }

  std::string folder;
};

TEST_F(AccessTest, ATokenIsOneLineWhetherOrNotItEnds) {
  for (const char* end : {"", "\n"}) {
    const auto token = Token::read(write(std::string(kFileToken) + end));
    ASSERT_TRUE(token) << token.error();
    EXPECT_TRUE(token->is(kFileToken));
    EXPECT_FALSE(token->is(std::string(kFileToken) + "0"));
    EXPECT_FALSE(token->is("0123456789abcdef0123456789abcdeF"));
    EXPECT_FALSE(token->is(""));
  }
}

TEST_F(AccessTest, ATokenThatOtherUsersMayReadIsNone) {
  EXPECT_EQ(fault(kFileToken, 0600), "");
  for (const mode_t mode : {0644U, 0642U, 0641U}) {
    const std::string why = fault(kFileToken, mode);
    EXPECT_NE(why.find("every user"), std::string::npos) << why;
    EXPECT_NE(why.find("expected 0640"), std::string::npos) << why;
  }
}

TEST_F(AccessTest, AShortALongOrABrokenTokenIsRefusedWithWhatIsExpected) {
  const std::string expected = ": expected one line of 32 to 256 characters";
  EXPECT_EQ(fault(std::string(32, 'x')), "");
  EXPECT_EQ(fault(std::string(256, 'x') + "\n"), "");
  EXPECT_EQ(fault(std::string(31, 'x')).find("holds a token of 31 characters" + expected), 0u);
  EXPECT_EQ(fault("").find("holds a token of 0 characters"), 0u);
  EXPECT_EQ(fault(std::string(257, 'x')).find("holds more than a token" + expected), 0u);
  EXPECT_EQ(fault(std::string(10'000'000, 'x')), "cannot be read: larger than 4096 bytes");
  for (const char* broken : {"\n", "\nmore", " ", "\t", "\r\n", "\xc3\xa4", "\x7f"})
    EXPECT_NE(fault(kFileToken + std::string(broken) + "x").find(expected), std::string::npos) << broken;
}

TEST_F(AccessTest, WhatIsNoFileIsRefusedWithoutWaiting) {
  EXPECT_EQ(Token::read(folder + "/none").error(), "cannot be read: No such file or directory");
  EXPECT_NE(Token::read(folder).error().find("no regular file"), std::string::npos);
  const std::string pipe = folder + "/pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_NE(Token::read(pipe).error().find("no regular file"), std::string::npos);
}

// Root may read it: without the note the check would be silent and the service would not start.
TEST_F(AccessTest, RootIsToldOfATokenFileThatTheServicesUserCannotRead) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can find out what another user may read";
  constexpr const char* kUser = "nobody";  // every Debian has it
  const passwd* const user = getpwnam(kUser);
  ASSERT_NE(user, nullptr);
  const std::string path = write(kFileToken, 0600);
  chmod(folder.c_str(), 0755);
  const std::string root = getgrgid(0)->gr_name;
  EXPECT_EQ(unreadable_token_note(path, kUser),
            "the user nobody, as whom the unit of systemd runs the service, cannot read " + path + " (root:" + root +
                ", mode 0600): chgrp nogroup " + path + " and chmod 0640 it");
  ASSERT_EQ(chown(path.c_str(), 0, user->pw_gid), 0);
  EXPECT_NE(unreadable_token_note(path, kUser), "") << "the group has no right yet";
  chmod(path.c_str(), 0640);
  EXPECT_EQ(unreadable_token_note(path, kUser), "");
  chmod(folder.c_str(), 0700);
  EXPECT_NE(
      unreadable_token_note(path, kUser).find("cannot enter the folder " + folder + " (root:" + root + ", mode 0700)"),
      std::string::npos)
      << unreadable_token_note(path, kUser);
  EXPECT_EQ(geteuid(), 0U);
  EXPECT_TRUE(Token::read(path)) << "and root is root again";
}

TEST_F(AccessTest, NothingIsSaidOfAUserOrAFileThatIsNotThere) {
  EXPECT_EQ(unreadable_token_note(write(kFileToken, 0600), "no-such-user"), "");
  EXPECT_EQ(unreadable_token_note(folder + "/none", "nobody"), "");
}

TEST_F(AccessTest, OnLoopbackEverybodyReadsAndNobodyChangesWithoutAToken) {
  for (const char* listen : {"127.0.0.1:80", "127.8.8.8:80", "[::1]:80", "localhost:80"}) {
    const auto read = access(std::string("listen = \"") + listen + "\"\n");
    ASSERT_TRUE(read) << listen;
    EXPECT_TRUE(read->open);
    EXPECT_FALSE(read->token);
  }
}

TEST_F(AccessTest, TheNetworkIsServedOnlyWhereTheRigFileSaysWhoAsksWhoItIs) {
  write(kFileToken);
  for (const char* address : {"0.0.0.0:80", "192.0.2.1:80", "[::]:80", "[::ffff:127.0.0.1]:80"}) {
    const std::string listen = std::string("listen = \"") + address + "\"\n";
    const std::string why = mistake(listen);
    EXPECT_EQ(why.find("rig.toml:19:10: \"listen\" is \"" + std::string(address) + "\""), 0u) << why;
    EXPECT_NE(why.find("expected a token_file, or behind_proxy = true"), std::string::npos) << why;
    const auto guarded = access(listen + "token_file = \"token\"\n");
    ASSERT_TRUE(guarded);
    EXPECT_FALSE(guarded->open);
    EXPECT_TRUE(guarded->token && guarded->token->is(kFileToken)) << "beside the rig file";
    const auto proxied = access(listen + "behind_proxy = true\n");
    ASSERT_TRUE(proxied);
    EXPECT_TRUE(proxied->open);
    EXPECT_FALSE(proxied->token) << "and nothing can be changed";
  }
  EXPECT_NE(mistake("listen = \"0.0.0.0:80\"\nbehind_proxy = false\n"), "");
}

TEST_F(AccessTest, PlcsOfTheNetworkReadOnlyWhereTheRigFileSaysThatAllMay) {
  const auto mistake_in = [this](const std::string& keys) {
    const auto checked = check_modbus_access(*rig_file("[modbus_server]\n" + keys).modbus_server);
    return checked ? "" : config::to_string("rig.toml", checked.error().front());
  };
  for (const char* address : {"127.0.0.1:1502", "[::1]:1502", "localhost:1502"})
    EXPECT_EQ(mistake_in(std::string("listen = \"") + address + "\"\n"), "");
  for (const char* address : {"0.0.0.0:1502", "192.0.2.1:1502", "[::]:1502"}) {
    const std::string listen = std::string("listen = \"") + address + "\"\n";
    for (const char* more : {"", "open_to_network = false\n"})
      EXPECT_EQ(
          mistake_in(listen + more),
          "rig.toml:19:10: \"listen\" is \"" + std::string(address) +
              "\", which other computers reach, and Modbus asks nobody who it is: expected open_to_network = true, "
              "where all who reach it may read, or 127.0.0.1");
    EXPECT_EQ(mistake_in(listen + "open_to_network = true\n"), "");
  }
}

TEST_F(AccessTest, ATokenFileThatCannotBeUsedIsAMistakeAtItsKey) {
  EXPECT_EQ(mistake("token_file = \"token\"\n"),
            "rig.toml:19:14: token_file \"" + folder + "/token\" cannot be read: No such file or directory");
}

}  // namespace
}  // namespace dwell
