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

// What the estimates and verifications of the files have been through, so that none of it goes untested.
struct Covered {
  int estimates = 0, verifications = 0, of_ended = 0, objections = 0, put_off = 0, with_faults = 0, with_causes = 0;

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
      put_off += from["may_search"] == false;
      with_faults += !from["at_fault"].empty();
    }
    return true;
  }
};

// Writes the run and expects of a replay that all of it is the same.
void expect_the_same(const std::string& file, const std::string& rig_text, const std::vector<Record>& stream,
                     Covered& covered) {
  const auto written = test::write_run(
      file, rig_text, stream, {.model = [&](record::StoredModel& model) { return covered.note(model); }});
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
  EXPECT_GT(covered.put_off, 0);
}

TEST(ReplayOfModels, GivesCausesAndObjectionsAgainWhereTheRigFileIsWrong) {
  const test::TemporaryFolder folder;
  Covered covered;
  expect_the_same(folder.path("wrong.dwell"), bench().rig_text(1.2), bench_stream(), covered);
  EXPECT_GT(covered.objections, 0);
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
  const Printed fewer = changed("estimate", [](Value& from, Value&) {
    from["readings"] = from["readings"].get<int>() - 5;
  });
  EXPECT_EQ(fewer.code, kNo);
  EXPECT_NE(fewer.out.find("estimate.from.from_s"), std::string::npos) << fewer.out;
  const Printed nowhere = changed("estimate", [](Value& from, Value&) { from["last"] = 4'000'000'000; });
  EXPECT_EQ(nowhere.code, kNo);
  EXPECT_NE(nowhere.out.find("the replay has no such readings"), std::string::npos) << nowhere.out;
  const Printed later = changed("verification", [](Value& from, Value&) { from["position"] = 4'000'000'000; });
  EXPECT_EQ(later.code, kNo);
  EXPECT_NE(later.out.find("no such dwell"), std::string::npos) << later.out;
}

TEST_F(ReplayOfOneRun, SaysOfAnOlderProgramsEstimateThatItCannotBeCompared) {
  const Printed older = changed("estimate", [](Value& from, Value&) { from.erase("may_search"); });
  EXPECT_EQ(older.code, kDone) << older.out << older.err;
  EXPECT_EQ(older.json()["compared"]["estimates"], written.estimates - 1);
  ASSERT_EQ(older.json()["notes"].size(), 1U);
  EXPECT_EQ(older.json()["notes"][0],
            "estimates of an older program, which did not store all that they were made from: 1; not compared");
}

TEST_F(ReplayOfOneRun, RefusesAnEntryThatIsNoneInOneLine) {
  const Printed many = changed("estimate", [](Value& from, Value&) { from["readings"] = 2'000'000'000; });
  EXPECT_EQ(many.code, kUsage);
  EXPECT_NE(many.err.find("from 2000000000 readings; an estimate takes 1000000 at most"), std::string::npos) << many.err;
  const Printed text = changed("verification", [](Value& from, Value&) { from["evidence"] = "all"; });
  EXPECT_EQ(text.code, kUsage);
  EXPECT_NE(text.err.find("from: last: expected to stand in an object"), std::string::npos) << text.err;
  const Printed foreign = changed("estimate", [](Value& from, Value&) {
    from["at_fault"] = {{{"channel", "y77"}, {"what", "stuck"}}};
  });
  EXPECT_EQ(foreign.code, kUsage);
  EXPECT_NE(foreign.err.find("from: channel: expected one of the rig file's"), std::string::npos) << foreign.err;
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
