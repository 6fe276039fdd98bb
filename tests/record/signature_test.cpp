// Signing a run that the service still has open.
#include "daemon/record/signature.hpp"

#include <gtest/gtest.h>

#include "tests/record/altered_files.hpp"
#include "tests/record/audited.hpp"

namespace dwell::record {
namespace {

// A run's end is written with the block after it. Closing the file then takes some waits for the disk.
TEST(Signature, RightAfterTheEndWaitsUntilTheServiceHasClosedTheRun) {
  const Scratch scratch(true);
  PersonalSignature signature;
  signature.name = "Anna";
  signature.meaning = "reviewed";
  signature.utc = "2026-11-24T08:00:00.000000Z";
  signature.person = Person{1000, "anna"};
  for (const bool by_service : {true, false}) {
    const std::string path = scratch.path(by_service ? "a.dwell" : "b.dwell");
    const RunHeader header = sample_header(7, sample_key());
    ChainWriter service = *ChainWriter::create(path, ChainSort::run, "dwell/run/" + header.id, sample_key());
    ASSERT_TRUE(service.append("run", 0, to_json(header)));
    ASSERT_TRUE(service.commit());
    const auto write_end = [&] {
      return service.append("end", 1, to_json(RunEnd{"operator", 0, 0, "2026-11-23T03:13:00Z"})).has_value() &&
             service.commit().has_value();
    };
    const auto sign = [&](const WhileBusy& busy) {
      return by_service ? sign_by_service(path, signature, sample_key(), busy)
                        : sign_by_own_key(path, signature, sample_other(), busy);
    };
    const auto too_early = sign([](int tries) { return tries < 3; });
    ASSERT_FALSE(too_early);
    EXPECT_EQ(too_early.error(), path + ": the run has not ended; only a closed run can be signed");
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

}  // namespace
}  // namespace dwell::record
