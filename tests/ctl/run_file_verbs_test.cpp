// The verbs that take a run file as they take a recording as text.
#include "tests/ctl/replayed_runs.hpp"

namespace dwell::ctl {
namespace {

using RunFileVerbs = ReplayTest;

TEST_F(RunFileVerbs, IdentifyGivesTheDwellsThatTheRunStored) {
  const std::string file = write("run.dwell");
  const Printed seen = printed([&] { return identify_recording({.data = file, .method = "harmonic", .json = true}); });
  ASSERT_EQ(seen.code, kDone) << seen.err;
  const Value answer = seen.json(), same = replayed(file).json();
  EXPECT_EQ(answer["dwells"], same["dwells"]) << "to the bit, and on the same axis";
  EXPECT_EQ(answer["dwells"][0]["start_utc"], written.header.start_utc);
  const Printed motion = printed([&] { return identify_recording({.data = file, .method = "motion", .json = true}); });
  ASSERT_EQ(motion.code, kDone) << motion.err;
  EXPECT_NEAR(motion.json()["motion"]["elements"][0]["stiffness"]["value"].get<double>(), 24000.0, 250.0);
}

TEST_F(RunFileVerbs, VerifyAndExportTakeARunFile) {
  const std::string file = write("run.dwell");
  const Printed verdict = printed([&] { return verify_recording({.data = file, .dwell = {}, .json = true}); });
  EXPECT_EQ(verdict.code, kDone) << verdict.out << verdict.err;
  EXPECT_EQ(verdict.json()["verdict"], "adequate");
  const std::string out = folder.path("model");
  EXPECT_EQ(printed([&] { return export_model({.data = file, .folder = out, .dwell = {}}); }).code, kDone);
  EXPECT_NE(contents_of(out + "/mass.mtx").find("1 1 12.5"), std::string::npos);
}

TEST_F(RunFileVerbs, ARecordingAsTextNeedsItsRigFile) {
  const std::string csv = folder.file("r.csv", "t,y0\n0,1\n1,2\n");
  const Printed seen = printed([&] { return identify_recording({.data = csv}); });
  EXPECT_EQ(seen.code, kUsage);
  EXPECT_NE(seen.err.find("--rig"), std::string::npos) << seen.err;
}

TEST_F(RunFileVerbs, ADwellThatWentOnWhenTheRunWasCutOffIsShownAsItWas) {
  StreamBuilder stream(bench(), {.frequency_hz = bench().frequency_hz, .amplitude = 3e-3}, 5);
  stream.add(Kind::run, 0, static_cast<std::uint8_t>(RunEdge::begins));
  stream.run_to(9.0);
  test::Changes changes;
  changes.without_end = true;
  const std::string file = folder.path("cut.dwell");
  written = test::write_run(file, bench().rig_text(), stream.cut_off(), changes);
  ASSERT_EQ(written.finals, 0);
  const Printed page = printed([&] { return show_run(file, false); });
  EXPECT_NE(page.out.find("dwell 1 · measuring, "), std::string::npos) << page.out;
  EXPECT_NE(page.out.find("of data; it went on when the record stopped"), std::string::npos) << page.out;
  EXPECT_NE(page.out.find(" kN/m"), std::string::npos) << page.out;
  const Printed json = printed([&] { return show_run(file, true); });
  ASSERT_EQ(json.json()["dwells"].size(), 1u);
  EXPECT_EQ(json.json()["dwells"][0]["state"], "measuring");
}

// Its number of format alone differs, and this program cannot read what a newer format holds.
TEST_F(RunFileVerbs, AFileOfANewerFormatCannotBeAudited) {
  constexpr std::size_t kVersion = 63;  // the lowest byte of user_version in SQLite's header
  std::string bytes = contents_of(write("run.dwell"));
  for (const auto& [version, code] : {std::pair('\3', kUsage), std::pair('\1', kNo)}) {
    bytes[kVersion] = version;
    const std::string file = folder.file("other.dwell", bytes);
    AuditRequest request;
    request.files = {file};
    const Printed seen = printed([&] { return audit_files(request); });
    EXPECT_EQ(seen.code, code) << seen.out << seen.err;
    if (code == kNo) continue;
    EXPECT_EQ(seen.out, "");
    EXPECT_NE(seen.err.find(file + ": cannot be audited: a run file of format 3; this program knows format 2"),
              std::string::npos)
        << seen.err;
  }
}

}  // namespace
}  // namespace dwell::ctl
