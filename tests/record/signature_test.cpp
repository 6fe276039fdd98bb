// Signing a run that the service still has open.
#include "daemon/record/signature.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <random>
#include <thread>

#include "tests/record/altered_files.hpp"
#include "tests/record/audited.hpp"

namespace dwell::record {
namespace {

// A run that the service has begun: its first entry, not committed yet.
ChainWriter begun(const std::string& path) {
  const RunHeader header = sample_header(7, sample_key());
  ChainWriter service = *ChainWriter::create(path, ChainSort::run, "dwell/run/" + header.id, sample_key());
  EXPECT_TRUE(service.append("run", 0, to_json(header)));
  return service;
}

Result<void> append_end(ChainWriter& service) {
  return service.append("end", 1, to_json(RunEnd{"operator", 0, 0, "2026-11-23T03:13:00Z"}));
}

// A run's end is written with the block after it. Closing the file then takes some waits for the disk.
TEST(Signature, RightAfterTheEndWaitsUntilTheServiceHasClosedTheRun) {
  const Scratch scratch(true);
  PersonalSignature signature = sample_words();
  signature.person = Person{1000, "anna"};
  for (const bool by_service : {true, false}) {
    const std::string path = scratch.path(by_service ? "a.dwell" : "b.dwell");
    ChainWriter service = begun(path);
    ASSERT_TRUE(service.commit());
    const auto write_end = [&] { return append_end(service).and_then([&] { return service.commit(); }).has_value(); };
    const auto sign = [&](const WhileBusy& busy) {
      return by_service ? sign_by_service(path, signature, sample_key(), busy)
                        : sign_by_own_key(path, signature, sample_other(), busy);
    };
    const auto too_early = sign([](int tries) { return tries < 3; });
    ASSERT_FALSE(too_early);
    EXPECT_EQ(too_early.error(),
              path + ": the run has no end: it is still recorded or was cut off; only a run with an end can be signed");
    int waits = 0;
    bool ended = false;
    const auto given_up = sign([&](int tries) {
      if (!ended) return ended = write_end();
      return (waits = tries) < 3;
    });
    EXPECT_EQ(waits, 3);
    ASSERT_FALSE(given_up);
    EXPECT_EQ(given_up.error(), path + ": another process has it open for writing");
    const auto made = sign([&](int tries) { return tries < 2 || service.close().has_value(); });
    EXPECT_TRUE(made) << made.error();
    EXPECT_EQ(audited(path).state, AuditState::intact);
  }
}

// Closing the file while it is read spoils the reading, at whatever instant it comes.
TEST(Signature, WhileTheServiceClosesTheFileIsTriedAgain) {
  const Scratch scratch(true);
  std::mt19937_64 rng(4);
  std::string noise(1 << 16, ' ');
  for (int round = 0; round < 100; ++round) {
    const std::string path = scratch.path("r" + std::to_string(round) + ".dwell");
    ChainWriter service = begun(path);
    for (int i = 0; i < 20; ++i) {
      for (char& c : noise) c = static_cast<char>('a' + rng() % 26);
      StoredEvent event{1, "2026-11-24T08:00:00Z", "state", noise, {}, "", "", ""};
      ASSERT_TRUE(service.append("event", 1, to_json(event)));
    }
    ASSERT_TRUE(append_end(service).and_then([&] { return service.commit(); }));
    std::thread closes([&service, wait = std::chrono::microseconds(rng() % 1500)] {
      std::this_thread::sleep_for(wait);
      EXPECT_TRUE(service.close());
    });
    const auto made = sign_by_own_key(path, sample_words(), sample_other());
    closes.join();
    ASSERT_TRUE(made) << "round " << round << ": " << made.error();
  }
}

}  // namespace
}  // namespace dwell::record
