// `dwellctl replay --models`: estimates by any motion and verifications, computed again from a run file.
#include <algorithm>
#include <bit>

#include "tests/ctl/replayed_runs.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell::ctl {
namespace {

Printed replayed_with_models(const std::string& file) {
  return printed([&] { return replay({.file = file, .models = true, .json = true}); });
}

// Counts what the files' estimates and verifications hold, so that no case goes untested.
struct Covered {
  int estimates = 0, verifications = 0, of_ended = 0, objections = 0, may_not_search = 0, with_terms = 0,
      with_faults = 0, with_causes = 0;

  bool note(const record::StoredModel& model) {
    const Value from = Value::parse(model.from), result = Value::parse(model.result);
    if (model.kind == "verification") {
      ++verifications;
      of_ended += from["ended"] == true;
      with_causes += !result["missing"].empty();
    } else {
      ++estimates;
      of_ended += from["dwell"].is_number();
      objections += result["objection"].is_object();
      may_not_search += from["may_search"] == false;
      with_terms += result["motion"].is_object() && !result["motion"]["missing"].empty();
      with_faults += !from["at_fault"].empty();
    }
    return true;
  }
};

// Writes the run and expects of a replay that all of it is the same.
void expect_the_same(const std::string& file, const std::string& rig_text, const std::vector<Record>& stream,
                     Covered& covered) {
  const auto written = test::write_run(file, rig_text, stream,
                                       {.model = [&](record::StoredModel& model) { return covered.note(model); }});
  const Printed seen = replayed_with_models(file);
  const Value answer = seen.json();
  ASSERT_EQ(seen.code, kDone) << answer["differences"].dump(1).substr(0, 2000) << seen.err;
  EXPECT_EQ(answer["identical"], true);
  EXPECT_EQ(answer["compared"]["results"], written.results + written.finals);
  EXPECT_EQ(answer["compared"]["estimates"], written.estimates);
  EXPECT_EQ(answer["compared"]["verifications"], written.verifications);
  EXPECT_TRUE(answer["notes"].empty()) << answer["notes"];
}

TEST(ReplayOfModels, GivesEachEstimateAndVerificationAgainToTheBit) {
  const test::TemporaryFolder folder;
  constexpr int kRigs = draws(4, 1);
  Covered covered;
  for (std::uint64_t seed = 1; seed <= kRigs; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 rng(seed);
    const SimulatedRig rig = SimulatedRig::random(rng);
    expect_the_same(folder.path(std::to_string(seed) + ".dwell"), rig.rig_text(), test::eventful_stream(rig, rng),
                    covered);
  }
  EXPECT_GT(covered.estimates, 2 * kRigs);
  EXPECT_GT(covered.verifications, kRigs);
  EXPECT_GT(covered.of_ended, kRigs);
  EXPECT_GT(covered.may_not_search, 0);
}

TEST(ReplayOfModels, GivesCausesAndObjectionsAgainWhereTheRigFileIsWrong) {
  const test::TemporaryFolder folder;
  Covered covered;
  expect_the_same(folder.path("wrong.dwell"), bench().rig_text(1.2), bench_stream(), covered);
  EXPECT_GT(covered.objections, 0);
  EXPECT_GT(covered.with_terms, 0) << "an estimate names what the rig file lacks";
  EXPECT_GT(covered.with_causes, 0);
}

TEST(ReplayOfModels, KnowsTheChannelsThatWereAtFault) {
  const test::TemporaryFolder folder;
  std::vector<Record> stream = bench_stream();
  for (Record& record : stream)
    if (record.kind == Kind::sample && record.channel == 1) record.value = std::clamp(record.value, -2.0, 2.0);
  Covered covered;
  expect_the_same(folder.path("clipped.dwell"), bench().rig_text(), stream, covered);
  EXPECT_GT(covered.with_faults, 0);
}

struct ReplayOfOneRun : ReplayTest {
  // change: of an estimate, or of a verification, and of the object that its text holds.
  Printed changed(const std::string& kind, const std::function<void(Value& from, Value& result)>& change) {
    std::filesystem::remove(folder.path("changed.dwell"));
    bool done = false;
    return replayed_with_models(write("changed.dwell", {.model = [&](record::StoredModel& model) {
                                        if (model.kind != kind || std::exchange(done, true)) return true;
                                        Value from = Value::parse(model.from), result = Value::parse(model.result);
                                        change(from, result);
                                        model.from = from.dump();
                                        model.result = result.dump();
                                        return true;
                                      }}));
  }
};

TEST_F(ReplayOfOneRun, NamesTheOneNumberOfWhichTheLowestBitIsFlipped) {
  const auto flip = [](Value& number) {
    number = std::bit_cast<double>(std::bit_cast<std::uint64_t>(number.get<double>()) ^ 1U);
  };
  const Printed estimate = changed("estimate", [&](Value&, Value& result) { flip(result["motion"]["start_s"]); });
  EXPECT_EQ(estimate.code, kNo);
  ASSERT_EQ(estimate.json()["differences"].size(), 1U) << estimate.out << estimate.err;
  EXPECT_EQ(estimate.json()["differences"][0]["what"], "estimate.result.motion.start_s");
  const Printed verification = changed("verification", [&](Value&, Value& result) { flip(result["e_n"]); });
  EXPECT_EQ(verification.code, kNo);
  ASSERT_EQ(verification.json()["differences"].size(), 1U) << verification.out << verification.err;
  EXPECT_EQ(verification.json()["differences"][0]["what"], "verification.result.e_n");
}

TEST_F(ReplayOfOneRun, NamesAnEntryThatRestsOnOtherReadingsThanItSays) {
  const Printed fewer =
      changed("estimate", [](Value& from, Value&) { from["readings"] = from["readings"].get<int>() - 5; });
  EXPECT_EQ(fewer.code, kNo);
  EXPECT_NE(fewer.out.find("estimate.from.from_s"), std::string::npos) << fewer.out;
}

// Each is the one difference: all other entries are compared and are the same.
TEST_F(ReplayOfOneRun, NamesAnEntryThatCannotBeComputedAgainAndComparesTheOthers) {
  const auto expect = [&](const std::string& kind, const std::function<void(Value & from)>& change,
                          const std::string& why) {
    const Printed seen = changed(kind, [&](Value& from, Value&) { change(from); });
    const Value answer = seen.json();
    EXPECT_EQ(seen.code, kNo) << why;
    ASSERT_EQ(answer["differences"].size(), 1U) << why << answer["differences"];
    EXPECT_NE(answer["differences"][0].dump().find(why), std::string::npos) << answer["differences"];
    EXPECT_EQ(answer["compared"]["estimates"], written.estimates - (kind == "estimate" ? 1 : 0)) << why;
    EXPECT_EQ(answer["compared"]["verifications"], written.verifications - (kind == "verification" ? 1 : 0)) << why;
  };
  expect(
      "estimate", [](Value& from) { from["last"] = 4'000'000'000; }, "the stream has no such reading");
  expect(
      "estimate", [](Value& from) { from["last"] = 0; }, "the stream has no such reading");
  expect(
      "estimate", [](Value& from) { from["dwell"] = 999; }, "no such dwell ends in the replay");
  expect(
      "estimate", [](Value& from) { from["readings"] = 2'000'000'000; }, "one takes 1000000 at most");
  expect(
      "estimate",
      [](Value& from) {
        from["at_fault"] = {{{"channel", "y77"}, {"what", "stuck"}}};
      },
      "channel: expected one of the rig file's");
  expect(
      "verification", [](Value& from) { from["position"] = 4'000'000'000; }, "the replay has no such dwell");
  expect(
      "verification", [](Value& from) { from["evidence"]["last"] = 4'000'000'000; }, "or not these readings");
  expect(
      "verification", [](Value& from) { from["evidence"] = "all"; }, "last: expected to stand in an object");
}

TEST_F(ReplayOfOneRun, SaysOfAnOlderProgramsEstimateThatItCannotBeCompared) {
  const Printed older = changed("estimate", [](Value& from, Value&) { from.erase("may_search"); });
  EXPECT_EQ(older.code, kDone) << older.out << older.err;
  EXPECT_EQ(older.json()["compared"]["estimates"], written.estimates - 1);
  ASSERT_EQ(older.json()["notes"].size(), 1U);
  EXPECT_EQ(older.json()["notes"][0],
            "estimates of an older program, which did not store all that they were made from: 1; not compared");
}

TEST_F(ReplayOfOneRun, SaysThatItComparesNeitherUnlessAsked) {
  const Printed seen = replayed(write("run.dwell", {.model = [](record::StoredModel&) { return true; }}));
  EXPECT_EQ(seen.code, kDone);
  EXPECT_EQ(seen.json()["compared"]["estimates"], 0);
  ASSERT_EQ(seen.json()["notes"].size(), 1U) << seen.out;
  EXPECT_EQ(seen.json()["notes"][0], "estimates by any motion and verifications are not compared; --models does that");
}

}  // namespace
}  // namespace dwell::ctl
