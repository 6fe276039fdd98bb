// `dwellctl replay --rig`: child files, and what is compared with their parents.
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "config/rig_file.hpp"
#include "daemon/ctl/child_file.hpp"
#include "daemon/ctl/identify.hpp"
#include "daemon/ctl/run_source.hpp"
#include "daemon/estimate/measurement.hpp"
#include "daemon/record/run_reader.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/dwell_line.hpp"
#include "tests/ctl/replayed_runs.hpp"

namespace dwell::ctl {
namespace {

// --rig: what a corrected rig file gives, and the child file that keeps it.
struct ChildTest : ReplayTest {
  ChildTest() { ::setenv("XDG_CONFIG_HOME", folder.path("config").c_str(), 1); }
  Printed make_child(const std::string& file, const std::string& rig_text, const std::string& output) {
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

std::vector<Record> stream_with_fault_and_loss() {
  StreamBuilder builder(bench(), {.frequency_hz = 6.0, .amplitude = 3e-3, .ramp_s = 0.2}, 6);
  builder.run_to(5.0);
  builder.add(Kind::fault, 0, static_cast<std::uint8_t>(Fault::timeout), 3.0);
  builder.add(Kind::loss, 1, static_cast<std::uint8_t>(Loss::late), 2.0);
  builder.run_to(12.0);
  return builder.end();
}

TEST_F(ChildTest, AChildHoldsWhatTheOtherRigFileGivesAndTheParentStaysAsItIs) {
  const std::string parent = write("run.dwell"), child = folder.path("child.dwell");
  const std::string before = contents_of(parent);
  const std::string other = bench().rig_text(1.002);
  const Printed seen = make_child(parent, other, child);
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

// What is done to a child by whoever writes it anew; false: the entry is left out.
struct Forgery {
  std::function<bool(record::StoredResult&)> result = [](record::StoredResult&) { return true; };
  std::function<bool(record::StoredEvent&)> event = [](record::StoredEvent&) { return true; };
};

// Written with the entries of `child`, each given to `alter`, and signed by a key of its own.
void forge_child(const std::string& child, const std::string& forged, const record::RunHeader& header,
                 const Forgery& alter) {
  auto reader = record::RunReader::open(child);
  ASSERT_TRUE(reader);
  auto file = ChildFile::create(forged, header, *record::SigningKey::make("forger"), 0);
  ASSERT_TRUE(file) << file.error();
  ASSERT_TRUE(reader->results(false, [&](record::StoredResult result) {
    if (alter.result(result)) file->add(0, result);
    return true;
  }));
  ASSERT_TRUE(reader->events([&](record::StoredEvent event) {
    if (alter.event(event)) file->add(0, event);
    return true;
  }));
  ASSERT_TRUE(file->finish(1, *reader->end()));
}

TEST_F(ChildTest, NobodyIsAdvisedToEnterTheSignatureUnderAChildIntoALedger) {
  const std::string child = folder.path("child.dwell"), key = folder.path("key");
  ASSERT_EQ(make_child(write("run.dwell"), bench().rig_text(1.002), child).code, kDone);
  ASSERT_TRUE(record::SigningKey::make("anna")->save(key));
  Service nowhere;
  nowhere.control = folder.path("none");
  SignOptions options;
  options.file = child;
  options.meaning = "reviewed";
  options.name = "Anna";
  options.key = key;
  const Printed signed_child = printed([&] { return sign(nowhere, options); });
  EXPECT_EQ(signed_child.code, kDone) << signed_child.err;
  EXPECT_NE(signed_child.out.find("not in the ledger: no ledger knows child files\n"), std::string::npos)
      << signed_child.out;
  EXPECT_EQ(signed_child.out.find("--enter"), std::string::npos) << signed_child.out;
}

TEST_F(ChildTest, AChildIsComparedWithItsParent) {
  const std::string parent = write("run.dwell"), child = folder.path("child.dwell");
  ASSERT_EQ(make_child(parent, bench().rig_text(1.002), child).code, kDone);
  const auto against = [&](const std::string& file) {
    return printed([&] { return replay({.file = parent, .against = file, .json = true}); });
  };
  const Printed same = against(child);
  EXPECT_EQ(same.code, kDone) << same.err;
  EXPECT_EQ(same.json()["identical"], true);
  EXPECT_GT(same.json()["compared"]["results"], written.finals);

  const record::RunHeader header = record::RunReader::open(child)->header();
  const auto forged = [&](const char* name, record::RunHeader its, const Forgery& alter) {
    forge_child(child, folder.path(name), std::move(its), alter);
    return against(folder.path(name));
  };
  const Forgery as_it_is;
  EXPECT_EQ(forged("copy.dwell", header, as_it_is).code, kDone) << "whoever signs it: the results are those";
  const Printed altered = forged("altered.dwell", header, {.result = [](record::StoredResult& result) {
                                   if (result.final) result.dwell.replace(result.dwell.find("\"end_s\":") + 8, 1, "9");
                                   return true;
                                 }});
  EXPECT_EQ(altered.code, kNo);
  EXPECT_EQ(altered.json()["identical"], false);
  const Printed fewer =
      forged("fewer.dwell", header,
             {.result = [n = 0](record::StoredResult& result) mutable { return result.final || ++n != 3; }});
  EXPECT_EQ(fewer.code, kNo) << "a result that is missing";
  EXPECT_EQ(fewer.json()["differences"].at(0)["replayed"], "published here");
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

TEST_F(ChildTest, EachEventThatIsAnotherIsNamed) {
  const std::string parent = folder.path("run.dwell"), child = folder.path("child.dwell");
  test::write_run(parent, bench().rig_text(), stream_with_fault_and_loss());
  ASSERT_EQ(make_child(parent, bench().rig_text(1.002), child).code, kDone);
  const record::RunHeader header = record::RunReader::open(child)->header();
  const auto differences = [&](const std::function<bool(record::StoredEvent&)>& alter) {
    const std::string file = folder.path("forged.dwell");
    std::filesystem::remove(file);
    forge_child(child, file, header, {.event = alter});
    const Printed seen = printed([&] { return replay({.file = parent, .against = file, .json = true}); });
    EXPECT_EQ(seen.json()["identical"], seen.code == kDone) << seen.err;
    return seen.json()["differences"];
  };
  const Printed same = printed([&] { return replay({.file = parent, .against = child, .json = true}); });
  EXPECT_EQ(same.code, kDone) << same.out;
  EXPECT_GE(same.json()["compared"]["events"], 5) << "three states, a fault, a loss";
  const auto is_fault = [](const record::StoredEvent& event) { return event.what == "fault"; };
  EXPECT_EQ(differences([](record::StoredEvent&) { return true; }).size(), 0U);

  const Value other_text = differences([&](record::StoredEvent& event) {
    if (is_fault(event)) event.text += "!";
    return true;
  });
  ASSERT_EQ(other_text.size(), 1U) << other_text;
  EXPECT_EQ(other_text[0]["what"], "event.text");
  EXPECT_EQ(other_text[0]["stored"], other_text[0]["replayed"].get<std::string>() + "!");
  const Value missing = differences([&](record::StoredEvent& event) { return !is_fault(event); });
  ASSERT_EQ(missing.size(), 1U) << missing;
  EXPECT_EQ(missing[0]["what"], "event");
  EXPECT_EQ(missing[0]["stored"], nullptr);
  EXPECT_EQ(missing[0]["replayed"].get<std::string>().substr(0, 7), "fault: ");
  const Value moved = differences([&](record::StoredEvent& event) {
    if (is_fault(event)) event.position += 1000;
    return true;
  });
  EXPECT_EQ(moved.size(), 2U) << "one too many there, one too few here: " << moved;
  const Value by_someone = differences([&](record::StoredEvent& event) {
    if (is_fault(event)) event.person = record::Person{1000, "anna"};
    if (event.what == "loss") event.comment = "c";
    return true;
  });
  EXPECT_EQ(by_someone.size(), 2U) << by_someone;
}

TEST_F(ChildTest, AChildHoldsTheEventsOfItsReplay) {
  const std::vector<Record> stream = stream_with_fault_and_loss();
  const std::string parent = folder.path("run.dwell"), child = folder.path("child.dwell");
  test::write_run(parent, bench().rig_text(), stream);
  const std::string other = bench().rig_text(1.002);
  ASSERT_EQ(make_child(parent, other, child).code, kDone);

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

TEST_F(ChildTest, TheScaleOfAChannelCanBeCorrected) {
  const std::string parent = write("run.dwell");
  std::string other = bench().rig_text();
  const std::size_t at = other.find("name = \"reaction\"");
  other.insert(at, "scale = 1.0003\n");
  const auto was = computed(parent, bench().rig_text()), now = computed(parent, other);
  EXPECT_NEAR(now.at(0).elements.at(1).stiffness.value, 1.0003 * was.at(0).elements.at(1).stiffness.value,
              1e-9 * was.at(0).elements.at(1).stiffness.value);
  const Printed seen = make_child(parent, other, "");
  ASSERT_EQ(seen.code, kDone) << seen.err;
  EXPECT_EQ(seen.json()["child"], nullptr);
  EXPECT_EQ(seen.json()["dwells"][0]["elements"][1]["stiffness"]["value"].get<double>(),
            now.at(0).elements.at(1).stiffness.value);
}

TEST_F(ChildTest, ChannelsMayStandInAnotherOrderButMustBeTheSame) {
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
    const Printed seen = make_child(parent, other, child);
    EXPECT_EQ(seen.code, kUsage);
    EXPECT_NE(seen.err.find("expected the channels of"), std::string::npos) << seen.err;
    EXPECT_FALSE(std::filesystem::exists(child));
  }
}

// A child carries its parent's head and a signature of its own: it would lend both to what somebody altered.
TEST_F(ChildTest, NoChildIsMadeOfATamperedParent) {
  const std::string parent = write("run.dwell"), child = folder.path("child.dwell");
  std::string bytes = contents_of(parent);
  const auto at = bytes.find("\"y1\"");
  ASSERT_NE(at, std::string::npos);
  bytes.replace(at, 4, "\"y2\"");
  std::ofstream(parent, std::ios::binary) << bytes;
  const Printed seen = make_child(parent, bench().rig_text(), child);
  EXPECT_EQ(seen.code, kUsage);
  EXPECT_NE(seen.err.find("was altered: the chain breaks here; no child was written"), std::string::npos) << seen.err;
  EXPECT_FALSE(std::filesystem::exists(child));
}

TEST_F(ChildTest, IsWrittenAtNoNameThatMeansSomethingElse) {
  const std::string parent = write("run.dwell");
  (void)folder.file("ledger.dwell-ledger", "");
  for (const auto& [name, found] :
       {std::pair(std::string("-"), "standard output is no file"),
        std::pair(folder.path("a.dwell-wal"), "has the name of a file beside a run"),
        std::pair(folder.path("next-2.new"), "has the name of a run that the service makes in advance")}) {
    const Printed seen = make_child(parent, bench().rig_text(), name);
    EXPECT_EQ(seen.code, kUsage);
    EXPECT_NE(seen.err.find(name + ": " + found), std::string::npos) << seen.err;
    EXPECT_FALSE(std::filesystem::exists(name));
  }
}

// The run's own file tells of a channel's state from the run's begin on. Its pipeline was born before, with the states
// that held then.
TEST_F(ChildTest, TellsNoStateFromBeforeItsRunBegan) {
  StreamBuilder stream(bench(), {.frequency_hz = 6.0, .amplitude = 3e-3, .ramp_s = 0.2}, 6);
  for (std::uint16_t channel = 0; channel < 3; ++channel) stream.add(Kind::channel_state, channel, 0);
  stream.run_to(1.0);
  stream.add(Kind::run, 0, static_cast<std::uint8_t>(RunEdge::begins));
  stream.run_to(2.0);
  stream.add(Kind::channel_state, 1, static_cast<std::uint8_t>(Fault::silent));
  stream.run_to(5.0);
  const std::string parent = folder.path("run.dwell"), child = folder.path("child.dwell");
  test::write_run(parent, bench().rig_text(), stream.end());
  (void)make_child(parent, bench().rig_text(), child);
  std::vector<std::string> faults;
  auto reader = record::RunReader::open(child);
  ASSERT_TRUE(reader) << reader.error();
  ASSERT_TRUE(reader->events([&](const record::StoredEvent& event) {
    if (event.what == "fault") faults.push_back(event.text);
    return true;
  }));
  EXPECT_EQ(faults, std::vector<std::string>{"channel y1 does not deliver: silent"});
}

TEST_F(ChildTest, WritesOverNothing) {
  const std::string parent = write("run.dwell"), kept = folder.file("kept.dwell", "kept");
  EXPECT_EQ(make_child(parent, bench().rig_text(), kept).code, kUsage);
  EXPECT_EQ(contents_of(kept), "kept");
  EXPECT_EQ(make_child(parent, bench().rig_text(), parent).code, kUsage);
  EXPECT_EQ(replayed(parent).code, kDone) << "the parent is unharmed";
}

}  // namespace
}  // namespace dwell::ctl
