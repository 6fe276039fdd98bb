// `dwellctl replay` on run files of simulated rigs, and what else takes run files.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "config/rig_file.hpp"
#include "daemon/ctl/child_file.hpp"
#include "daemon/ctl/commands.hpp"
#include "daemon/ctl/identify.hpp"
#include "daemon/ctl/run_source.hpp"
#include "daemon/estimate/measurement.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/dwell_line.hpp"
#include "tests/core/bench_rig.hpp"
#include "tests/ctl/run_file_builder.hpp"
#include "tests/ctl/temporary.hpp"
#include "tests/under_sanitizer.hpp"

namespace dwell::ctl {
namespace {

using Value = nlohmann::json;
using test::SimulatedRig;
using test::StreamBuilder;

struct Printed {
  int code = -1;
  std::string out, err;
  [[nodiscard]] Value json() const { return Value::parse(out, nullptr, false); }
};
template <class Verb>
Printed printed(const Verb& verb) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Printed result;
  result.code = verb();
  result.out = testing::internal::GetCapturedStdout();
  result.err = testing::internal::GetCapturedStderr();
  return result;
}
Printed replayed(const std::string& file) {
  return printed([&] { return replay({.file = file, .json = true}); });
}

std::string contents_of(const std::string& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

// One mass between the table and a load cell; a drive that starts, holds for 14 s and stops.
const SimulatedRig& bench() {
  static const SimulatedRig rig{{Boundary::clamped, {12.5}, {24000.0, 9000.0}, {160.0, 90.0}}, 6.0, 200.0, 1e-6};
  return rig;
}
std::vector<Record> bench_stream() {
  StreamBuilder stream(bench(), {.frequency_hz = bench().frequency_hz}, 5);
  stream.run_to(1.0);
  stream.set_drive({.frequency_hz = bench().frequency_hz, .amplitude = 3e-3, .ramp_s = 0.2});
  stream.run_to(2.0);
  stream.add(Kind::run, 0, static_cast<std::uint8_t>(RunEdge::begins));
  stream.run_to(15.0);
  stream.set_drive({.frequency_hz = bench().frequency_hz, .ramp_s = 0.2});
  stream.run_to(18.0);
  return stream.end();
}

struct ReplayTest : testing::Test {
  std::string write(const std::string& name, const test::Changes& changes = {}) {
    written = test::write_run(folder.path(name), bench().rig_text(), bench_stream(), changes);
    return folder.path(name);
  }
  test::TemporaryFolder folder;
  test::WrittenRun written;
};

TEST(Replay, GivesEveryPublishedResultAgainToTheBit) {
  const test::TemporaryFolder folder;
  constexpr int kRigs = draws(40, 8);
  int finals = 0, settled = 0;
  for (std::uint64_t seed = 1; seed <= kRigs; ++seed) {
    std::mt19937_64 rng(seed);
    const SimulatedRig rig = SimulatedRig::random(rng);
    const std::string file = folder.path(std::to_string(seed) + ".dwell");
    const auto written = test::write_run(file, rig.rig_text(), test::eventful_stream(rig, rng));
    const Printed seen = replayed(file);
    const Value answer = seen.json();
    ASSERT_EQ(seen.code, kDone) << seed << "\n" << answer["differences"].dump(1).substr(0, 2000) << seen.err;
    EXPECT_EQ(answer["identical"], true) << seed;
    EXPECT_EQ(answer["same_origin"], true);
    EXPECT_EQ(answer["compared"]["results"], written.results + written.finals);
    EXPECT_EQ(answer["compared"]["finals"], written.finals);
    EXPECT_EQ(answer["dwells"].size(), static_cast<std::size_t>(written.finals));
    EXPECT_GT(answer["compared"]["numbers"].get<int>(), 20 * written.results);
    EXPECT_TRUE(answer["notes"].empty());
    finals += written.finals;
    settled += written.settled;
  }
  EXPECT_GT(finals, 3 * kRigs / 2) << "the streams hold too little";
  EXPECT_GT(settled, kRigs);
}

// The pipeline of a large rig fits for so long that it works in slices, and results wait for it.
TEST(Replay, GivesTheSameAroundLongPiecesOfWork) {
  std::mt19937_64 rng(3);
  SimulatedRig large{random_chain(rng, 12, Boundary::free, 10.0), 10.0, 500.0, 1e-6};
  for (double& r : large.chain.damping) r *= 5;
  StreamBuilder stream(large, {.frequency_hz = 10.0, .amplitude = 2e-3, .ramp_s = 0.1}, 1);
  stream.run_to(12.0);
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

TEST_F(ReplayTest, ToldAtAnotherPlaceOfTheStreamAResultIsAnother) {
  const Printed seen = replayed(write("moved.dwell", {.result = [](record::StoredResult& result) {
                                        if (!result.final && result.position > 500 && result.position < 800)
                                          result.position += 20;
                                        return true;
                                      }}));
  EXPECT_EQ(seen.code, kNo);
  EXPECT_FALSE(seen.json()["differences"].empty());
}

TEST_F(ReplayTest, OfAnotherBuildOnlyWhatExceedsTheToleranceCounts) {
  for (const double parts_of_u : {1e-4, 1e-2}) {
    const std::string file = folder.path("other.dwell");
    std::filesystem::remove(file);
    const Printed seen =
        replayed(write("other.dwell", {.header = [](record::RunHeader& h) { h.origin.cpu = "z80"; },
                                       .result =
                                           [&](record::StoredResult& result) {
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

// --rig: what a corrected rig file gives, and the child file that keeps it.
struct AmendTest : ReplayTest {
  AmendTest() { ::setenv("XDG_CONFIG_HOME", folder.path("config").c_str(), 1); }
  Printed amend(const std::string& file, const std::string& rig_text, const std::string& output) {
    return printed([&] {
      return replay(
          {.file = file, .rig = folder.file("other.toml", rig_text), .output = output, .comment = "why", .json = true});
    });
  }
  // The finals as the pipeline gives them from the records themselves.
  static std::vector<Dwell> computed(const std::string& file, const std::string& rig_text) {
    auto reader = record::RunReader::open(file);
    const auto rig = config::parse(rig_text, "other.toml", {});
    auto channels = ChannelMap::between(reader->header(), file, rig->rig, "other.toml");
    return identify(rig->rig, RunSource(std::move(*reader), std::move(*channels))).value();
  }
};

TEST_F(AmendTest, AChildHoldsWhatTheOtherRigFileGivesAndTheParentStaysAsItIs) {
  const std::string parent = write("run.dwell"), child = folder.path("child.dwell");
  const std::string before = contents_of(parent);
  const std::string other = bench().rig_text(1.002);
  const Printed seen = amend(parent, other, child);
  ASSERT_EQ(seen.code, kDone) << seen.err;
  EXPECT_EQ(contents_of(parent), before);
  EXPECT_NE(seen.err.find("a key of your own was made"), std::string::npos) << seen.err;

  auto reader = record::RunReader::open(child);
  ASSERT_TRUE(reader) << reader.error();
  const record::RunHeader& header = reader->header();
  EXPECT_EQ(header.run, 0);
  EXPECT_NE(header.id, written.header.id);
  EXPECT_EQ(header.parent_id, written.header.id);
  EXPECT_EQ(header.parent_head.size(), 64U);
  EXPECT_EQ(header.begun_by, "replay");
  EXPECT_EQ(header.comment, "why");
  EXPECT_EQ(header.rig.text, other);
  EXPECT_EQ(header.start_utc, written.header.start_utc);
  ASSERT_TRUE(reader->end());
  EXPECT_EQ(reader->end()->why, "replay");

  const std::vector<Dwell> expected = computed(parent, other);
  ASSERT_EQ(expected.size(), static_cast<std::size_t>(written.finals));
  std::size_t finals = 0, results = 0;
  const auto rig = config::parse(other, "other.toml", {});
  ASSERT_TRUE(reader->results(false, [&](const record::StoredResult& result) {
    ++(result.final ? finals : results);
    if (!result.final) return true;
    const Value stored = Value::parse(result.dwell);
    const Value again = Value::parse(to_json(expected.at(finals - 1), rig->rig, {}));
    EXPECT_EQ(stored["elements"], again["elements"]);
    EXPECT_EQ(stored["phasors"], again["phasors"]);
    EXPECT_EQ(stored["rig_sha256"], rig->sha256);
    return true;
  }));
  EXPECT_EQ(finals, expected.size());
  EXPECT_EQ(results, static_cast<std::size_t>(written.results));
  const double heavier = expected.at(0).elements.at(0).stiffness.value;
  const double was = computed(parent, bench().rig_text()).at(0).elements.at(0).stiffness.value;
  EXPECT_GT(std::fabs(heavier - was), 1e-4 * was) << "the mass makes no difference";

  const Printed of_child = replayed(child);
  EXPECT_EQ(of_child.code, kUsage);
  EXPECT_NE(of_child.err.find(written.header.id), std::string::npos) << of_child.err;
}

// What the service would have told of this stream with the other rig file.
std::vector<std::string> states_told(const std::vector<Record>& stream, const std::string& rig_text) {
  const auto rig = config::parse(rig_text, "other.toml", {});
  std::vector<std::string> told;
  Measurement measurement(rig->rig, KeptDwells(1, 1'000'000), [&](const RunEvent& event) {
    if (event.kind == RunEvent::Kind::state_changed) told.push_back(state_line(event.before, *event.dwell));
  });
  for (const Record& record : stream) measurement.take(record);
  measurement.finish();
  return told;
}

// Written with the results of `child`, each given to `alter`, and signed by a key of its own.
void forge_child(const std::string& child, const std::string& forged, const record::RunHeader& header,
                 const std::function<bool(record::StoredResult&)>& alter) {
  auto reader = record::RunReader::open(child);
  ASSERT_TRUE(reader);
  auto file = ChildFile::create(forged, header, *record::SigningKey::make("forger"), 0);
  ASSERT_TRUE(file) << file.error();
  ASSERT_TRUE(reader->results(false, [&](record::StoredResult result) {
    if (alter(result)) file->add(0, result);
    return true;
  }));
  ASSERT_TRUE(file->finish(1, *reader->end()));
}

TEST_F(AmendTest, AChildIsComparedWithItsParent) {
  const std::string parent = write("run.dwell"), child = folder.path("child.dwell");
  ASSERT_EQ(amend(parent, bench().rig_text(1.002), child).code, kDone);
  const auto against = [&](const std::string& file) {
    return printed([&] { return replay({.file = parent, .against = file, .json = true}); });
  };
  const Printed same = against(child);
  EXPECT_EQ(same.code, kDone) << same.err;
  EXPECT_EQ(same.json()["identical"], true);
  EXPECT_GT(same.json()["compared"]["results"], written.finals);

  const record::RunHeader header = record::RunReader::open(child)->header();
  const auto forged = [&](const char* name, record::RunHeader its,
                          const std::function<bool(record::StoredResult&)>& alter) {
    forge_child(child, folder.path(name), std::move(its), alter);
    return against(folder.path(name));
  };
  const auto as_it_is = [](record::StoredResult&) { return true; };
  EXPECT_EQ(forged("copy.dwell", header, as_it_is).code, kDone) << "whoever signs it: the results are those";
  const Printed altered = forged("altered.dwell", header, [](record::StoredResult& result) {
    if (result.final) result.dwell.replace(result.dwell.find("\"end_s\":") + 8, 1, "9");
    return true;
  });
  EXPECT_EQ(altered.code, kNo);
  EXPECT_EQ(altered.json()["identical"], false);
  EXPECT_EQ(
      forged("fewer.dwell", header, [n = 0](record::StoredResult& result) mutable { return result.final || ++n != 3; })
          .code,
      kNo)
      << "a result that is missing";
  record::RunHeader other = header;
  other.parent_id = std::string(32, '0');
  const Printed of_another = forged("other.dwell", other, as_it_is);
  EXPECT_EQ(of_another.code, kNo);
  EXPECT_NE(of_another.err.find("was computed from run 000"), std::string::npos) << of_another.err;
  other = header;
  other.parent_head = std::string(64, '0');
  EXPECT_NE(forged("head.dwell", other, as_it_is).err.find("another state of this run"), std::string::npos);
  other = header;
  other.rig.sha256 = std::string(64, '0');
  EXPECT_NE(forged("rig.dwell", other, as_it_is).err.find("whose SHA-256 it states"), std::string::npos);
  EXPECT_EQ(against(parent).code, kUsage) << "is no child";
}

TEST_F(AmendTest, AChildHoldsTheEventsOfItsReplay) {
  StreamBuilder builder(bench(), {.frequency_hz = 6.0, .amplitude = 3e-3, .ramp_s = 0.2}, 6);
  builder.run_to(5.0);
  builder.add(Kind::fault, 0, static_cast<std::uint8_t>(Fault::timeout), 3.0);
  builder.add(Kind::loss, 1, static_cast<std::uint8_t>(Loss::late), 2.0);
  builder.run_to(12.0);
  const std::vector<Record> stream = builder.end();
  const std::string parent = folder.path("run.dwell"), child = folder.path("child.dwell");
  test::write_run(parent, bench().rig_text(), stream);
  const std::string other = bench().rig_text(1.002);
  ASSERT_EQ(amend(parent, other, child).code, kDone);

  std::vector<std::string> states, others, utc;
  std::uint64_t fault_at = 0;
  auto reader = record::RunReader::open(child);
  ASSERT_TRUE(reader) << reader.error();
  ASSERT_TRUE(reader->events([&](const record::StoredEvent& event) {
    (event.what == "state" ? states : others).push_back(event.what == "state" ? event.text : event.what);
    if (event.what == "fault") fault_at = event.position;
    utc.push_back(event.utc);
    return true;
  }));
  EXPECT_EQ(states, states_told(stream, other));
  EXPECT_GE(states.size(), 3u) << "settling, measuring, idle";
  EXPECT_EQ(others, (std::vector<std::string>{"fault", "loss"}));
  ASSERT_GT(fault_at, 0u);
  EXPECT_EQ(stream.at(fault_at - 1).kind, Kind::fault);
  for (const std::string& instant : utc) {
    EXPECT_GE(instant, "2026-11-23T03:12:17.250000Z");
    EXPECT_LE(instant, "2026-11-23T03:12:30.000000Z");
  }
}

TEST_F(AmendTest, TheScaleOfAChannelCanBeCorrected) {
  const std::string parent = write("run.dwell");
  std::string other = bench().rig_text();
  const std::size_t at = other.find("name = \"reaction\"");
  other.insert(at, "scale = 1.0003\n");
  const auto was = computed(parent, bench().rig_text()), now = computed(parent, other);
  EXPECT_NEAR(now.at(0).elements.at(1).stiffness.value, 1.0003 * was.at(0).elements.at(1).stiffness.value,
              1e-9 * was.at(0).elements.at(1).stiffness.value);
  const Printed seen = amend(parent, other, "");
  ASSERT_EQ(seen.code, kDone) << seen.err;
  EXPECT_EQ(seen.json()["child"], nullptr);
  EXPECT_EQ(seen.json()["dwells"][0]["elements"][1]["stiffness"]["value"].get<double>(),
            now.at(0).elements.at(1).stiffness.value);
}

TEST_F(AmendTest, ChannelsMayStandInAnotherOrderButMustBeTheSame) {
  const std::string parent = write("run.dwell"), child = folder.path("child.dwell");
  const std::string rig = bench().rig_text();
  const std::size_t first = rig.find("[[channel]]"), second = rig.find("[[channel]]", first + 1);
  const std::string moved = rig.substr(0, first) + rig.substr(second) + rig.substr(first, second - first);
  const auto was = computed(parent, rig), now = computed(parent, moved);
  EXPECT_NEAR(now.at(0).elements.at(0).stiffness.value, was.at(0).elements.at(0).stiffness.value,
              1e-6 * was.at(0).elements.at(0).stiffness.value);
  std::string renamed = rig;
  renamed.replace(renamed.find("\"y1\""), 4, "\"z1\"");
  for (const std::string& other :
       {renamed, rig + "[[channel]]\nname = \"oil\"\nmeasures = \"auxiliary\"\nunit = \"K\"\n"}) {
    const Printed seen = amend(parent, other, child);
    EXPECT_EQ(seen.code, kUsage);
    EXPECT_NE(seen.err.find("expected the channels of"), std::string::npos) << seen.err;
    EXPECT_FALSE(std::filesystem::exists(child));
  }
}

// A child carries its parent's head and a signature of its own: it would lend both to what somebody altered.
TEST_F(AmendTest, NoChildIsMadeOfATamperedParent) {
  const std::string parent = write("run.dwell"), child = folder.path("child.dwell");
  std::string bytes = contents_of(parent);
  const auto at = bytes.find("\"y1\"");
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 4, "\"y2\"");
  std::ofstream(parent, std::ios::binary) << bytes;
  const Printed seen = amend(parent, bench().rig_text(), child);
  EXPECT_EQ(seen.code, kUsage);
  EXPECT_NE(seen.err.find("was altered: the chain breaks here; no child was written"), std::string::npos) << seen.err;
  EXPECT_FALSE(std::filesystem::exists(child));
}

TEST_F(AmendTest, WritesOverNothing) {
  const std::string parent = write("run.dwell"), kept = folder.file("kept.dwell", "kept");
  EXPECT_EQ(amend(parent, bench().rig_text(), kept).code, kUsage);
  EXPECT_EQ(contents_of(kept), "kept");
  EXPECT_EQ(amend(parent, bench().rig_text(), parent).code, kUsage);
  EXPECT_EQ(replayed(parent).code, kDone) << "the parent is unharmed";
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

// The other verbs take a run file as they take a recording as text.
TEST_F(ReplayTest, IdentifyGivesTheDwellsThatTheRunStored) {
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

TEST_F(ReplayTest, VerifyAndExportTakeARunFile) {
  const std::string file = write("run.dwell");
  const Printed verdict = printed([&] { return verify_recording({.data = file, .dwell = {}, .json = true}); });
  EXPECT_EQ(verdict.code, kDone) << verdict.out << verdict.err;
  EXPECT_EQ(verdict.json()["verdict"], "adequate");
  const std::string out = folder.path("model");
  EXPECT_EQ(printed([&] { return export_model({.data = file, .folder = out, .dwell = {}}); }).code, kDone);
  EXPECT_NE(contents_of(out + "/mass.mtx").find("1 1 12.5"), std::string::npos);
}

TEST_F(ReplayTest, ARecordingAsTextNeedsItsRigFile) {
  const std::string csv = folder.file("r.csv", "t,y0\n0,1\n1,2\n");
  const Printed seen = printed([&] { return identify_recording({.data = csv}); });
  EXPECT_EQ(seen.code, kUsage);
  EXPECT_NE(seen.err.find("--rig"), std::string::npos) << seen.err;
}

}  // namespace
}  // namespace dwell::ctl
