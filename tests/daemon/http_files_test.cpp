// Files that are sent, and answers that are made later because they wait for the disk.
#include <gtest/gtest.h>

#include <deque>
#include <filesystem>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "daemon/record/chain_file.hpp"
#include "daemon/serve/aside.hpp"
#include "daemon/serve/http_server.hpp"
#include "tests/daemon/http_server_fixture.hpp"
#include "tests/daemon/sockets.hpp"
#include "tests/record/locked_for_others.hpp"

namespace dwell {
namespace {

using test::Answer;
using test::Client;
using test::expect_error;
using test::HttpServerTest;
using test::read_answer;

struct HttpFilesTest : HttpServerTest {};

TEST_F(HttpFilesTest, AnAnswerThatWaitsForTheDiskHoldsNobodyUp) {
  HttpOptions options;
  options.downloads = 2;
  begin(options);
  std::deque<Client> waiting;
  for (int i = 0; i < 2; ++i) {
    waiting.push_back(Client::tcp(port));
    waiting.back().send("GET /hangs HTTP/1.1\r\nHost: localhost\r\n\r\n");
  }
  while (stats().requests < 2) std::this_thread::yield();
  expect_error(ask("GET /later HTTP/1.1\r\nHost: localhost\r\n\r\n"), 503);
  EXPECT_EQ(ask("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 200) << "others are served";
  hold.release(2);
  for (Client& client : waiting) EXPECT_EQ(read_answer(client).body, "held");
  EXPECT_EQ(ask("GET /later HTTP/1.1\r\nHost: localhost\r\n\r\n").body, "read");
  expect_error(ask("GET /throws HTTP/1.1\r\nHost: localhost\r\n\r\n"), 500);
  Client head = Client::tcp(port);
  head.send("HEAD /later HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
  EXPECT_NE(read_answer(head, true).head.find("Content-Length: 4\r\n"), std::string::npos);
}

TEST_F(HttpFilesTest, AnAnswerThatStillWaitsDoesNotKeepTheServer) {
  begin();
  Client client = Client::tcp(port);
  client.send("GET /hangs HTTP/1.1\r\nHost: localhost\r\n\r\n");
  while (stats().requests < 1) std::this_thread::yield();
  thread.reset();
  hold.release();
  server.reset();
  EXPECT_EQ(client.all(), "");
}

TEST_F(HttpFilesTest, AFileIsSentAsItIsAndTheConnectionGoesOn) {
  const std::string bytes = made_file("a.dwell", 700'001);
  begin();
  Client client = Client::tcp(port);
  for (int i = 0; i < 2; ++i) {
    client.send(ask_for_file("a.dwell"));
    const Answer answer = read_answer(client);
    EXPECT_EQ(answer.status, 200);
    EXPECT_TRUE(answer.body == bytes);
    for (const char* field :
         {"Content-Disposition: attachment; filename=\"a.dwell\"\r\n", "Cache-Control: no-store\r\n",
          "Content-Type: application/vnd.sqlite3\r\n", "X-Content-Type-Options: nosniff\r\n"})
      EXPECT_NE(answer.head.find(field), std::string::npos) << field << answer.head;
  }
  client.send(ask_for_file("a.dwell", "HEAD"));
  EXPECT_NE(read_answer(client, true).head.find("Content-Length: 700001\r\n"), std::string::npos);
  made_file("empty.dwell", 0);
  client.send(ask_for_file("empty.dwell"));
  EXPECT_EQ(read_answer(client).status, 200);
  client.send("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n");
  EXPECT_EQ(read_answer(client).status, 200);
}

TEST_F(HttpFilesTest, AFileThatIsNoCompleteRunIsRefusedWithTheReason) {
  made_file("a.dwell", 1000);
  made_file("a.dwell-wal", 10);
  std::filesystem::create_symlink(folder.path("a.dwell"), folder.path("link.dwell"));
  std::filesystem::create_directory(folder.path("folder.dwell"));
  begin();
  Client client = Client::tcp(port);
  for (const auto& [name, status] :
       {std::pair("a.dwell", 409), {"link.dwell", 409}, {"folder.dwell", 409}, {"none.dwell", 404}}) {
    client.send(ask_for_file(name));
    expect_error(read_answer(client), status);
  }
}

// Retention may delete a run while it is downloaded: the open file keeps its bytes until the download has ended.
TEST_F(HttpFilesTest, AFileThatIsDeletedMeanwhileArrivesAndOneThatIsAlteredBreaksOff) {
  const std::string bytes = made_file("a.dwell", 12'000'000);
  begin();
  for (const bool deleted : {true, false}) {
    made_file("a.dwell", bytes.size());
    Client client = Client::tcp(port, 4096);
    client.send(ask_for_file("a.dwell"));
    client.until("\r\n\r\n");
    EXPECT_TRUE(client.exactly(1000) == bytes.substr(0, 1000));
    if (deleted)
      std::filesystem::remove(folder.path("a.dwell"));
    else
      std::filesystem::resize_file(folder.path("a.dwell"), bytes.size() + 1);
    const std::string rest = client.exactly(bytes.size() - 1000);
    if (deleted) {
      EXPECT_TRUE(rest == bytes.substr(1000));
    } else {
      EXPECT_LT(rest.size(), bytes.size() - 1000);
    }
  }
}

// fcntl(2): a process loses its locks on a file once it closes any descriptor of it.
TEST_F(HttpFilesTest, ARunThatIsSignedStaysLockedThoughItsDownloadEnds) {
  using record::ChainSort, record::ChainWriter;
  const std::string path = folder.path("a.dwell"), origin = "dwell/run/" + std::string(32, 'a');
  const auto key = *record::SigningKey::make("rig");
  {
    ChainWriter run = *ChainWriter::create(path, ChainSort::run, origin, key);
    ASSERT_TRUE(run.append("stream", 1, std::string(12'000'000, 'x')));
    ASSERT_TRUE(run.close());
  }
  begin();
  Client client = Client::tcp(port, 4096);
  client.send(ask_for_file("a.dwell"));
  client.until("\r\n\r\n");
  auto signing = ChainWriter::open(path, ChainSort::run, origin, key);
  ASSERT_TRUE(signing) << signing.error();
  ASSERT_TRUE(signing->append("signature", 1, "b"));
  ASSERT_TRUE(signing->commit());
  ASSERT_TRUE(record::locked_for_others(path));
  EXPECT_LT(client.all().size(), 12'000'000u) << "the file was altered meanwhile";
  // One that begins now is refused, behind all that the server had to do for the first one.
  expect_error(ask(ask_for_file("a.dwell")), 409);
  EXPECT_TRUE(record::locked_for_others(path));
  EXPECT_TRUE(signing->close());
}

TEST_F(HttpFilesTest, WhoDoesNotReadADownloadLosesItsPlace) {
  made_file("a.dwell", 30'000'000);
  HttpOptions options;
  options.downloads = 1;
  options.request_time = std::chrono::milliseconds(200);
  begin(options);
  Client slow = Client::tcp(port, 4096);
  slow.send(ask_for_file("a.dwell"));
  slow.until("\r\n\r\n");
  // 503: the slow client still has its place. 0: this client was too slow itself and was closed.
  int status = 503;
  for (int tries = 0; tries < 100'000 && (status == 503 || status == 0); ++tries) {
    Client client = Client::tcp(port);
    client.send(ask_for_file("a.dwell", "HEAD"));
    status = read_answer(client, true).status;
  }
  EXPECT_EQ(status, 200);
}

TEST_F(HttpFilesTest, SoManyFilesAreOnTheirWayAtOnceAndAllElseIsServedMeanwhile) {
  made_file("a.dwell", 30'000'000);
  HttpOptions options;
  options.downloads = 2;
  begin(options);
  std::vector<Client> slow;
  for (int i = 0; i < 2; ++i) {
    slow.push_back(Client::tcp(port, 4096));
    slow.back().send(ask_for_file("a.dwell"));
    slow.back().until("\r\n\r\n");
  }
  expect_error(ask(ask_for_file("a.dwell")), 503);
  EXPECT_EQ(ask("GET /hello HTTP/1.1\r\nHost: localhost\r\n\r\n").status, 200);
  slow.clear();
  int status = 503;
  while (status == 503) {
    Client client = Client::tcp(port);
    client.send(ask_for_file("a.dwell", "HEAD"));
    status = read_answer(client, true).status;
  }
  EXPECT_EQ(status, 200) << "a client that has gone leaves its place";
}

TEST_F(HttpFilesTest, AServerThatEndsWhileAFileIsOnItsWayLeavesNothingBehind) {
  made_file("a.dwell", 30'000'000);
  begin();
  Client client = Client::tcp(port, 4096);
  client.send(ask_for_file("a.dwell"));
  client.until("\r\n\r\n");
  thread->on_loop([this] {
    server.reset();
    return 0;
  });
  EXPECT_LT(client.all().size(), 30'000'000u);
}

// A piece that was written while the server ended asks for the next one after it.
TEST(Aside, WhatIsAskedForAfterTheEndIsDroppedAtOnce) {
  EventLoop loop;
  Aside aside(loop, "test");
  aside.close();
  auto held = std::make_shared<int>(0);
  const std::weak_ptr<int> seen = held;
  aside.ask([] { return 0; }, [held = std::move(held)](int) {});
  EXPECT_TRUE(seen.expired());
}

}  // namespace
}  // namespace dwell
