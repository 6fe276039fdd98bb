// A run read back with other programs: Python's csv, h5py, a reader of universal files from the format's description.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numeric>
#include <stdexcept>

#include "config/rig_file.hpp"
#include "daemon/ctl/identify.hpp"
#include "daemon/handon/csv.hpp"
#include "daemon/handon/hdf5.hpp"
#include "daemon/handon/output_file.hpp"
#include "daemon/handon/uff.hpp"
#include "drivers/replay/csv_recording.hpp"
#include "tests/handon/handed_run.hpp"

namespace dwell {
namespace {

using record::Scratch;

test::HandedRun written(const Scratch& scratch, test::HandedRun run = {}) {
  test::write(run, scratch.path("run.dwell"));
  test::dump_samples(run, scratch.path("samples"));
  return run;
}

std::uint64_t samples_of(const test::HandedRun& run) {
  return static_cast<std::uint64_t>(
      std::count_if(run.stream.begin(), run.stream.end(), [](const Record& r) { return r.kind == Kind::sample; }));
}

constexpr const char* kEver = "9000000000000000000";

TEST(HandedOnAsCsv, PythonReadsEveryInstantToTheNanosecondAndEveryValueToTheLastBit) {
  const Scratch scratch;
  const test::HandedRun run = written(scratch);
  for (const bool in_unit : {false, true}) {
    handon::Selection all = test::select(run);
    const auto count = export_csv(all, test::provenance(), {in_unit}, {scratch.path("run.csv"), true}, {});
    ASSERT_TRUE(count) << count.error();
    EXPECT_EQ(*count, samples_of(run));
    EXPECT_EQ(test::python("read_csv.py", {scratch.path("run.csv"), scratch.path("samples"), "0", kEver}), 0);
  }
}

TEST(HandedOnAsCsv, IdentifiesTheSameCoefficientsWithTheRigFileBesideIt) {
  const Scratch scratch;
  const test::HandedRun run = written(scratch);
  handon::Selection all = test::select(run);
  ASSERT_TRUE(export_csv(all, test::provenance(), {}, scratch.path("run.csv"), {}));
  const auto recording = read_csv(scratch.path("run.csv"));
  ASSERT_TRUE(recording) << recording.error();
  const std::vector<Dwell> again = ctl::identify(all.rig(), *recording);
  ASSERT_EQ(again.size(), run.dwells.size());
  ASSERT_EQ(again.size(), 1U);
  const ElementEstimate& stored = run.dwells[0].elements.at(0);
  const ElementEstimate& found = again[0].elements.at(0);
  EXPECT_NEAR(stored.stiffness.value, test::kStiffness, 3.0 * stored.stiffness.u);
  // The ticks of the run are not in the CSV: data may be cut into blocks a reading later.
  EXPECT_NEAR(found.stiffness.value, stored.stiffness.value, 1e-3 * stored.stiffness.u);
  EXPECT_NEAR(found.damping.value, stored.damping.value, 1e-3 * stored.damping.u);
}

TEST(HandedOnAsCsv, ARangeHoldsBothItsEndsAndNothingElse) {
  const Scratch scratch;
  const test::HandedRun run = written(scratch);
  // Ends exactly at samples.
  std::vector<std::int64_t> t_ns;
  const std::int64_t zero_ns = test::select(run).zero_ns();
  for (const Record& r : run.stream)
    if (r.kind == Kind::sample && r.channel == 1) t_ns.push_back(r.t_ns - zero_ns);
  const std::int64_t from_ns = t_ns[700], to_ns = t_ns[1500];
  handon::Selection part =
      test::select(run, {1e-9 * static_cast<double>(from_ns), 1e-9 * static_cast<double>(to_ns), {}});
  const auto count = export_csv(part, test::provenance(), {}, scratch.path("part.csv"), {});
  ASSERT_TRUE(count) << count.error();
  EXPECT_EQ(test::python("read_csv.py", {scratch.path("part.csv"), scratch.path("samples"), std::to_string(from_ns),
                                         std::to_string(to_ns)}),
            0);
}

TEST(HandedOnAsCsv, ADwellReachesFromItsArmingToItsEnd) {
  const Scratch scratch;
  const test::HandedRun run = written(scratch);
  const handon::Selection dwell = test::select(run, {{}, {}, 1});
  EXPECT_NEAR(dwell.axis_s(dwell.from_ns()), run.dwells[0].start_s, 1e-9);
  EXPECT_NEAR(dwell.axis_s(dwell.to_ns()), run.dwells[0].end_s, 1e-9);
  const auto none = handon::Selection::open(run.path, {{}, {}, 2});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().find("there is no dwell 2 in it; expected 1 to 1"), std::string::npos) << none.error();
}

TEST(HandedOnAsCsv, SecondsAreExact) {
  EXPECT_EQ(handon::exact_seconds(0), "0.000000000");
  EXPECT_EQ(handon::exact_seconds(-1), "-0.000000001");
  EXPECT_EQ(handon::exact_seconds(86'400'123'456'789), "86400.123456789");
  EXPECT_EQ(handon::exact_seconds(INT64_MIN), "-9223372036.854775808");
  EXPECT_EQ(handon::shortest(0.1), "0.1");
  EXPECT_EQ(handon::shortest(-0.0), "-0");
}

TEST(HandedOnAsHdf5, H5pyReadsTheSameBitsInstantsAndAttributes) {
  const Scratch scratch;
  test::HandedRun wanted;
  wanted.length_s = 100.0;  // more samples than a chunk holds
  wanted.events = {{2, "2026-11-23T03:12:18Z", "state", "drive recognized", {}, "", "", ""}};
  const test::HandedRun run = written(scratch, wanted);
  handon::Selection all = test::select(run);
  const auto count = export_hdf5(all, test::provenance(), scratch.path("run.h5"), {});
  ASSERT_TRUE(count) << count.error();
  EXPECT_EQ(*count, samples_of(run));
  const int code = test::python("read_hdf5.py",
                                {scratch.path("run.h5"), scratch.path("samples"), std::to_string(run.dwells.size())});
  if (code == 77) GTEST_SKIP() << "python3-h5py is not installed";
  EXPECT_EQ(code, 0);
}

TEST(HandedOnAsUff, AReaderByFixedColumnsFindsTheMotionWithinTheStatedError) {
  const Scratch scratch;
  test::HandedRun wanted;
  wanted.length_s = 15.0;  // the slow channel has 4 readings a second
  const test::HandedRun run = written(scratch, wanted);
  for (const bool binary : {false, true}) {
    handon::Selection all = test::select(run);
    const auto done = export_uff(all, test::provenance(), {binary}, {scratch.path("run.uff"), true}, {});
    ASSERT_TRUE(done) << done.error();
    EXPECT_EQ(done->samples, samples_of(run));
    EXPECT_EQ(done->datasets, 3U);
    EXPECT_EQ(test::python("read_uff.py", {scratch.path("run.uff"), binary ? "1" : "0", "1"}), 0);
  }
}

TEST(HandedOnAsUff, AGapEndsADatasetAndAnotherGoesOn) {
  const Scratch scratch;
  test::HandedRun wanted;
  wanted.length_s = 15.0;
  wanted.gap_from_s = 5.0;
  wanted.gap_to_s = 6.0;
  const test::HandedRun run = written(scratch, wanted);
  handon::Selection all = test::select(run);
  const auto done = export_uff(all, test::provenance(), {}, scratch.path("run.uff"), {});
  ASSERT_TRUE(done) << done.error();
  EXPECT_EQ(done->datasets, 4U);
  EXPECT_EQ(test::python("read_uff.py", {scratch.path("run.uff"), "0", "2"}), 0);
}

TEST(HandedOnAsUff, AStretchOfFewReadingsIsLeftOutAndCounted) {
  for (const int readings : {47, 48}) {
    const Scratch scratch;
    test::HandedRun wanted;
    wanted.length_s = 15.0;
    wanted.gap_from_s = (readings + 0.5) / wanted.rate_hz;
    wanted.gap_to_s = wanted.gap_from_s + 0.3;
    const test::HandedRun run = written(scratch, wanted);
    handon::Selection all = test::select(run);
    const auto done = export_uff(all, test::provenance(), {}, {scratch.path("run.uff"), true}, {});
    ASSERT_TRUE(done) << done.error();
    EXPECT_EQ(done->datasets, readings < 48 ? 3U : 4U);
    EXPECT_EQ(done->left_out, readings < 48 ? 47U : 0U);
  }
}

TEST(HandedOn, WhoStopsAmidAnExportLeavesNoFile) {
  const record::Scratch scratch;
  test::HandedRun run;
  run.length_s = 300.0;
  run.rate_hz = 1000.0;
  test::write(run, scratch.path("run.dwell"));
  const handon::Progress stop = [](double) { throw std::runtime_error("stopped"); };
  handon::Selection selection = test::select(run);
  EXPECT_THROW((void)export_csv(selection, test::provenance(), {}, scratch.path("o"), stop), std::runtime_error);
  EXPECT_THROW((void)export_hdf5(selection, test::provenance(), scratch.path("o"), stop), std::runtime_error);
  EXPECT_THROW((void)export_uff(selection, test::provenance(), {}, scratch.path("o"), stop), std::runtime_error);
  EXPECT_FALSE(std::filesystem::exists(scratch.path("o")) || std::filesystem::exists(scratch.path("o.part")));
}

TEST(HandedOn, TwoWritersDoNotWriteOneFileAtATime) {
  const record::Scratch scratch;
  auto one = handon::OutputFile::create(scratch.path("o"));
  ASSERT_TRUE(one) << one.error();
  one->write("one");
  const auto other = handon::OutputFile::create(scratch.path("o"));
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error(), scratch.path("o") + ": is being written already");
  ASSERT_TRUE(one->keep());
  EXPECT_EQ(record::Scratch::read(scratch.path("o")), "one");
  EXPECT_TRUE(handon::OutputFile::create({scratch.path("o"), true})) << "it is done";
}

TEST(HandedOn, WhatFailsLeavesNoFileAndSaysWhere) {
  const Scratch scratch;
  const test::HandedRun run = written(scratch);
  handon::Selection all = test::select(run);
  const std::string nowhere = scratch.path("missing/run.csv");
  const auto csv = export_csv(all, test::provenance(), {}, nowhere, {});
  ASSERT_FALSE(csv);
  EXPECT_NE(csv.error().find(nowhere + ": cannot be written: No such file"), std::string::npos) << csv.error();
  const auto hdf5 = export_hdf5(all, test::provenance(), nowhere, {});
  ASSERT_FALSE(hdf5);
  EXPECT_NE(hdf5.error().find(nowhere), std::string::npos) << hdf5.error();
  // A damaged run: the tables are there, the bytes of the stream are not what they were.
  std::string bytes = Scratch::read(run.path);
  for (std::size_t i = bytes.size() / 3; i < bytes.size(); i += 97) bytes[i] = static_cast<char>(bytes[i] ^ 0x55);
  const std::string damaged = scratch.write("damaged.dwell", bytes);
  if (auto selection = handon::Selection::open(damaged, {})) {
    EXPECT_FALSE(export_csv(*selection, test::provenance(), {}, scratch.path("damaged.csv"), {}));
    EXPECT_FALSE(export_hdf5(*selection, test::provenance(), scratch.path("damaged.h5"), {}));
    EXPECT_FALSE(export_uff(*selection, test::provenance(), {}, scratch.path("damaged.uff"), {}));
  }
  for (const auto& entry : std::filesystem::directory_iterator(scratch.path()))
    EXPECT_TRUE(entry.path().extension() == ".dwell" || entry.path().filename() == "samples") << entry.path();
}

}  // namespace
}  // namespace dwell
