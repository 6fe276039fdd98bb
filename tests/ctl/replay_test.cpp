// `dwellctl replay` on run files of simulated rigs.
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "tests/core/bench_rig.hpp"
#include "tests/ctl/replayed_runs.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell::ctl {
namespace {

TEST(Replay, GivesEveryPublishedResultAgainToTheBit) {
  const test::TemporaryFolder folder;
  constexpr int kRigs = draws(40, 8);
  std::ptrdiff_t finals = 0, settled = 0, changes = 0;
  for (std::uint64_t seed = 1; seed <= kRigs; ++seed) {
    std::mt19937_64 rng(seed);
    const SimulatedRig rig = SimulatedRig::random(rng);
    const std::string file = folder.path(std::to_string(seed) + ".dwell");
    const std::vector<Record> stream = test::eventful_stream(rig, rng);
    const auto written = test::write_run(file, rig.rig_text(), stream);
    const auto begins = std::find_if(stream.begin(), stream.end(),
                                     [](const Record& record) { return is_edge(record, RunEdge::begins); });
    const auto begins_at = static_cast<std::uint64_t>(1 + std::distance(stream.begin(), begins));
    const auto states = std::count_if(written.states.begin(), written.states.end(), [&](std::uint64_t position) {
      return position > begins_at && position < stream.size();
    });
    const Printed seen = replayed(file);
    const Value answer = seen.json();
    ASSERT_EQ(seen.code, kDone) << seed << "\n" << answer["differences"].dump(1).substr(0, 2000) << seen.err;
    EXPECT_EQ(answer["identical"], true) << seed;
    EXPECT_EQ(answer["same_origin"], true);
    EXPECT_EQ(answer["compared"]["results"], written.results + written.finals);
    EXPECT_EQ(answer["compared"]["finals"], written.finals);
    EXPECT_EQ(answer["compared"]["events"], states);
    changes += states;
    EXPECT_EQ(answer["dwells"].size(), static_cast<std::size_t>(written.finals));
    EXPECT_GT(answer["compared"]["numbers"].get<int>(), 20 * written.results);
    EXPECT_TRUE(answer["notes"].empty());
    finals += written.finals;
    settled += written.settled;
  }
  EXPECT_GT(changes, 2 * kRigs);
  EXPECT_GT(finals, 3 * kRigs / 2) << "the streams hold too little";
  EXPECT_GT(settled, kRigs);
}

// The pipeline of a large rig fits for so long that it works in slices, and results wait for it.
TEST(Replay, GivesTheSameAroundLongPiecesOfWork) {
  std::mt19937_64 rng(3);
  SimulatedRig large{random_chain(rng, 12, Boundary::free, 10.0), 10.0, 500.0, 1e-6};
  for (double& r : large.chain.damping) r *= 5;
  StreamBuilder stream(large, {.frequency_hz = 10.0, .amplitude = 2e-3, .ramp_s = 0.1}, 1);
  stream.run_to(11.0);
  stream.add(Kind::action, 0, static_cast<std::uint8_t>(Action::rearm));
  stream.run_to(20.0);
  const test::TemporaryFolder folder;
  const auto written = test::write_run(folder.path("large.dwell"), large.rig_text(), stream.end());
  const Printed seen = replayed(folder.path("large.dwell"));
  EXPECT_EQ(seen.code, kDone) << seen.json()["differences"].dump(1).substr(0, 2000) << seen.err;
  EXPECT_EQ(seen.json()["compared"]["finals"], 2);
  EXPECT_GT(written.busy, 10) << "no long work was in the way of a result";
}

// The numbers of a dwell, and how to reach them.
TEST_F(ReplayTest, NamesTheOneNumberOfWhichTheLowestBitIsFlipped) {
  for (const char* at :
       {"/elements/0/stiffness/value", "/elements/1/damping/u", "/phasors/2/phase_rad", "/phasors/0/harmonics/1",
        "/covariance/1/2", "/t_ref_s", "/frequency_hz/value", "/elements/0/budget/0/stiffness_share", "/settled_s"}) {
    std::string stored;
    Value index;
    const std::string file = write("flipped.dwell", {.result = [&](record::StoredResult& result) {
                                     Value dwell = Value::parse(result.dwell);
                                     if (!result.final || dwell["elements"].empty()) return true;
                                     double& number = dwell.at(Value::json_pointer(at)).get_ref<double&>();
                                     number = std::bit_cast<double>(std::bit_cast<std::uint64_t>(number) ^ 1U);
                                     stored = Value(number).dump();
                                     index = dwell["index"];
                                     result.dwell = dwell.dump();
                                     return true;
                                   }});
    const Printed seen = replayed(file);
    const Value answer = seen.json();
    EXPECT_EQ(seen.code, kNo) << at;
    EXPECT_EQ(answer["identical"], false);
    ASSERT_EQ(answer["differences"].size(), 1U) << at;
    const Value& difference = answer["differences"][0];
    std::string path = "/" + difference["what"].get<std::string>();
    for (char& c : path)
      if (c == '.' || c == '[') c = '/';
    std::erase(path, ']');
    EXPECT_EQ(path, at);
    EXPECT_EQ(difference["dwell"], index);
    EXPECT_EQ(difference["final"], true);
    EXPECT_EQ(difference["stored"].dump(), stored);
    EXPECT_NE(difference["replayed"].dump(), stored);
    std::filesystem::remove(file);
  }
}

TEST_F(ReplayTest, NamesATextAMemberAndAResultThatAreOthers) {
  const auto change = [&](const std::function<bool(Value&)>& to) {
    const std::string file = folder.path("changed.dwell");
    std::filesystem::remove(file);
    return replayed(write("changed.dwell", {.result = [&to](record::StoredResult& result) {
                            Value dwell = Value::parse(result.dwell);
                            const bool keep = !result.final || to(dwell);
                            result.dwell = dwell.dump();
                            return keep;
                          }}));
  };
  const Printed text = change([](Value& dwell) { return dwell["ended_by"] = "end", true; });
  EXPECT_EQ(text.code, kNo);
  EXPECT_EQ(text.json()["differences"].at(0)["what"], "ended_by");
  EXPECT_EQ(text.json()["differences"].at(0)["stored"], "end");
  const Printed gone = change([](Value& dwell) { return dwell.erase("t_ref_s"), true; });
  EXPECT_EQ(gone.json()["differences"].at(0)["what"], "t_ref_s");
  const Printed more = change([](Value& dwell) { return dwell["mass"] = 1.0, true; });
  EXPECT_EQ(more.json()["differences"].at(0)["what"], "mass");
  EXPECT_EQ(more.json()["differences"].at(0)["replayed"], nullptr);
  const Printed other_rig = change([](Value& dwell) { return dwell["rig_sha256"] = "00", true; });
  EXPECT_EQ(other_rig.json()["differences"].at(0)["what"], "rig_sha256");
  const Printed dropped = change([](Value&) { return false; });
  EXPECT_EQ(dropped.code, kNo);
  EXPECT_EQ(dropped.json()["differences"].at(0)["what"], "result");
  EXPECT_EQ(dropped.json()["differences"].at(0)["replayed"], "a dwell ends here");
}

TEST_F(ReplayTest, NamesAChangeOfStateThatIsGoneOrAnotherOrElsewhere) {
  const auto change = [&](const std::function<bool(record::StoredEvent&)>& to) {
    std::filesystem::remove(folder.path("changed.dwell"));
    return replayed(write("changed.dwell", {.state_event = [&to](record::StoredEvent& event) {
                            return event.text.find("-> idle") == std::string::npos || to(event);
                          }}));
  };
  const Printed same = change([](record::StoredEvent&) { return true; });
  EXPECT_EQ(same.code, kDone) << same.out;
  EXPECT_EQ(same.json()["compared"]["events"], 2)
      << "settling again, then idle; the first two came before the run began";
  const Printed gone = change([](record::StoredEvent&) { return false; });
  EXPECT_EQ(gone.code, kNo);
  ASSERT_EQ(gone.json()["differences"].size(), 1U);
  EXPECT_EQ(gone.json()["differences"][0]["what"], "event");
  EXPECT_EQ(gone.json()["differences"][0]["stored"], nullptr);
  const Printed other = change([](record::StoredEvent& event) { return event.text += ".", true; });
  EXPECT_EQ(other.code, kNo);
  ASSERT_EQ(other.json()["differences"].size(), 1U);
  EXPECT_EQ(other.json()["differences"][0]["what"], "event.text");
  const Printed elsewhere = change([](record::StoredEvent& event) { return ++event.position, true; });
  EXPECT_EQ(elsewhere.code, kNo);
  EXPECT_EQ(elsewhere.json()["differences"].size(), 2U) << "one too many here, one missing there";
}

TEST_F(ReplayTest, ToldAtAnotherPlaceOfTheStreamAResultIsAnother) {
  const Printed seen = replayed(write("moved.dwell", {.result = [](record::StoredResult& result) {
                                        if (!result.final && result.position > 500 && result.position < 800)
                                          result.position += 20;
                                        return true;
                                      }}));
  EXPECT_EQ(seen.code, kNo);
  EXPECT_FALSE(seen.json()["differences"].empty());
}

TEST_F(ReplayTest, OfAnotherProcessorOrProgramOnlyWhatExceedsTheToleranceCounts) {
  const auto another_processor = [](record::RunHeader& h) { h.origin.cpu = "z80"; };
  const auto other_sources = [](record::RunHeader& h) {
    ASSERT_EQ(h.origin.build.rfind("sources ", 0), 0U) << h.origin.build;
    char& digit = h.origin.build[8];
    digit = digit == '0' ? '1' : '0';
  };
  const std::vector<std::pair<std::function<void(record::RunHeader&)>, double>> cases{
      {another_processor, 1e-4}, {another_processor, 1e-2}, {other_sources, 1e-4}, {other_sources, 1e-2}};
  for (const auto& [changes, parts] : cases) {
    const double parts_of_u = parts;
    const std::string file = folder.path("other.dwell");
    std::filesystem::remove(file);
    const Printed seen =
        replayed(write("other.dwell", {.header = changes, .result = [&](record::StoredResult& result) {
                                         Value dwell = Value::parse(result.dwell);
                                         if (!result.final || dwell["elements"].empty()) return true;
                                         Value& c = dwell["elements"][0]["stiffness"];
                                         c["value"] = c["value"].get<double>() + parts_of_u * c["u"].get<double>();
                                         result.dwell = dwell.dump();
                                         return true;
                                       }}));
    const Value answer = seen.json();
    EXPECT_EQ(seen.code, parts_of_u < 1e-3 ? kDone : kNo);
    EXPECT_EQ(answer["identical"], false);
    EXPECT_EQ(answer["same_origin"], false);
    EXPECT_EQ(answer["within_tolerance"], parts_of_u < 1e-3);
    ASSERT_EQ(answer["differences"].size(), 1U);
    EXPECT_EQ(answer["differences"][0]["what"], "elements[0].stiffness.value");
    EXPECT_NEAR(answer["differences"][0]["difference_u"].get<double>(), parts_of_u, 1e-3 * parts_of_u);
  }
}

TEST_F(ReplayTest, ARunThatWasCutOffIsComparedAsFarAsItGoes) {
  StreamBuilder stream(bench(), {.frequency_hz = 6.0, .amplitude = 3e-3, .ramp_s = 0.2}, 6);
  stream.run_to(12.0);
  written = test::write_run(folder.path("cut.dwell"), bench().rig_text(), stream.cut_off(), {.without_end = true});
  const Printed seen = replayed(folder.path("cut.dwell"));
  EXPECT_EQ(seen.code, kDone) << seen.err;
  EXPECT_EQ(seen.json()["compared"]["results"], written.results);
  EXPECT_EQ(seen.json()["dwells"].size(), 1U) << "the dwell that was on is shown, as identify shows it";
}

TEST_F(ReplayTest, SaysInWordsWhatItFound) {
  const std::string file = write("run.dwell");
  const Printed same = printed([&] { return replay({.file = file}); });
  EXPECT_NE(same.out.find("rig bench\n"), std::string::npos);
  EXPECT_NE(same.out.find("identical: "), std::string::npos) << same.out;
  EXPECT_NE(same.out.find("bit for bit"), std::string::npos);
}

TEST_F(ReplayTest, RefusesWhatIsNoRun) {
  for (const std::string& file : {folder.path("none.dwell"), folder.file("text.dwell", "t,y0\n0,1\n"),
                                  folder.file("short.dwell", "SQLite format 3")}) {
    const Printed seen = replayed(file);
    EXPECT_EQ(seen.code, kUsage) << file;
    EXPECT_NE(seen.err.find(file), std::string::npos) << seen.err;
    EXPECT_EQ(std::count(seen.err.begin(), seen.err.end(), '\n'), 1) << seen.err;
  }
  std::vector<Record> late = bench_stream();
  late.erase(late.begin());
  test::write_run(folder.path("late.dwell"), bench().rig_text(), late);
  const Printed seen = replayed(folder.path("late.dwell"));
  EXPECT_EQ(seen.code, kUsage);
  EXPECT_NE(seen.err.find("armed"), std::string::npos) << seen.err;
}

}  // namespace
}  // namespace dwell::ctl
