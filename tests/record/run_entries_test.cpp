#include "daemon/record/run_entries.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

namespace dwell::record {
namespace {

RunHeader full_header() {
  RunHeader header;
  header.run = 17;
  header.id = "00112233445566778899aabbccddeeff";
  header.label = "Ölfilm, 2. Versuch";
  header.begun_by = "operator";
  header.person = {.uid = 1000, .name = "anna"};
  header.comment = "line one\nline \"two\"";
  header.start_utc = "2026-03-01T10:00:00.123456789Z";
  header.previous_head = std::string(64, 'a');
  header.parent_id = std::string(32, 'b');
  header.parent_head = std::string(64, 'c');
  header.vkey = "rig+1a2b3c4d+AAAA";
  header.rig = {.path = "rig.toml", .sha256 = std::string(64, 'd'), .text = "[rig]\nname = \"µ\"\n"};
  header.files = {{.path = "a.dbc", .sha256 = std::string(64, 'e'), .text = std::string("VERSION \"\xB0\"\0\r\n", 14)}};
  header.plugins = {{.driver = "modbus", .version = "0.1.0"}, {.driver = "can", .version = ""}};
  header.channels = {"table", "m1", "m2"};
  header.origin = {.version = "0.1.0", .build = "GNU", .cpu = "avx fma", .host = "rig", .time_zone = "Europe/Berlin"};
  header.origin.clock_synchronized = true;
  header.origin.clock_error_s = 0.1 + 0.2;
  return header;
}

TEST(RunEntries, AHeaderComesBackWhole) {
  const RunHeader header = full_header();
  const auto back = parse_run_header(to_json(header));
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ(back->run, 17);
  EXPECT_EQ(back->id, header.id);
  EXPECT_EQ(back->label, header.label);
  EXPECT_EQ(back->begun_by, "operator");
  ASSERT_TRUE(back->person);
  EXPECT_EQ(back->person->uid, 1000U);
  EXPECT_EQ(back->person->name, "anna");
  EXPECT_EQ(back->comment, header.comment);
  EXPECT_EQ(back->start_utc, header.start_utc);
  EXPECT_EQ(back->previous_head, header.previous_head);
  EXPECT_EQ(back->parent_id, header.parent_id);
  EXPECT_EQ(back->parent_head, header.parent_head);
  EXPECT_EQ(back->vkey, header.vkey);
  EXPECT_EQ(back->rig.path, "rig.toml");
  EXPECT_EQ(back->rig.sha256, header.rig.sha256);
  EXPECT_EQ(back->rig.text, header.rig.text);
  ASSERT_EQ(back->files.size(), 1U);
  EXPECT_EQ(back->files[0].text, header.files[0].text);  // not UTF-8, and with a zero byte
  ASSERT_EQ(back->plugins.size(), 2U);
  EXPECT_EQ(back->plugins[0].driver, "modbus");
  EXPECT_EQ(back->plugins[0].version, "0.1.0");
  EXPECT_EQ(back->channels, header.channels);
  EXPECT_EQ(back->origin.version, "0.1.0");
  EXPECT_EQ(back->origin.build, "GNU");
  EXPECT_EQ(back->origin.cpu, "avx fma");
  EXPECT_EQ(back->origin.host, "rig");
  EXPECT_EQ(back->origin.time_zone, "Europe/Berlin");
  EXPECT_TRUE(back->origin.clock_synchronized);
  EXPECT_EQ(back->origin.clock_error_s, 0.1 + 0.2);
  EXPECT_EQ(to_json(*back), to_json(header));
}

TEST(RunEntries, WhatIsEmptyIsLeftOutAndComesBackEmpty) {
  RunHeader header;
  header.origin.clock_error_s = std::numeric_limits<double>::quiet_NaN();
  const std::string body = to_json(header);
  for (const char* name : {"label", "person", "comment", "previous_head", "parent_id", "parent_head", "time_zone"})
    EXPECT_EQ(body.find(std::string("\"") + name + "\""), std::string::npos) << name;
  const auto back = parse_run_header(body);
  ASSERT_TRUE(back) << back.error();
  EXPECT_FALSE(back->person);
  EXPECT_TRUE(std::isnan(back->origin.clock_error_s));
}

TEST(RunEntries, TheOtherEntriesComeBackWhole) {
  const StoredEvent event{.position = 12,
                          .utc = "u",
                          .what = "action",
                          .text = "t",
                          .person = Person{.uid = 4294967295U, .name = ""},
                          .before = "b",
                          .after = "a",
                          .comment = "c"};
  const auto event_back = parse_event(to_json(event));
  ASSERT_TRUE(event_back) << event_back.error();
  EXPECT_EQ(
      to_json(*event_back),
      R"({"position":12,"utc":"u","what":"action","text":"t","person":{"uid":4294967295},"before":"b","after":"a","comment":"c"})");

  const RunEnd end{.why = "disk full", .records = std::numeric_limits<std::uint64_t>::max(), .samples = 3, .utc = "u"};
  const auto end_back = parse_run_end(to_json(end));
  ASSERT_TRUE(end_back) << end_back.error();
  EXPECT_EQ(to_json(*end_back), R"({"why":"disk full","records":18446744073709551615,"samples":3,"utc":"u"})");

  PersonalSignature signature{.name = "Anna",
                              .meaning = "reviewed",
                              .reason = "r",
                              .utc = "u",
                              .seq = 9,
                              .head = "h",
                              .person = Person{.uid = 1, .name = "anna"},
                              .vkey = {},
                              .note = {}};
  const auto by_service = parse_personal_signature(to_json(signature));
  ASSERT_TRUE(by_service) << by_service.error();
  const std::string front = R"({"name":"Anna","meaning":"reviewed","reason":"r","utc":"u","seq":9,"head":"h",)";
  EXPECT_EQ(to_json(*by_service), front + R"("person":{"uid":1,"name":"anna"}})");
  signature.person.reset();
  signature.vkey = "k";
  signature.note = "n\n";
  const auto by_own_key = parse_personal_signature(to_json(signature));
  ASSERT_TRUE(by_own_key) << by_own_key.error();
  EXPECT_EQ(to_json(*by_own_key), front + R"("vkey":"k","note":"n\n"})");
}

TEST(RunEntries, ADwellComesBackAsTheTextItWas) {
  const std::string dwell =
      R"({"z":1.0,"a":-0.0,"k":0.30000000000000004,"n":[1e-300,null,"µ"],"big":18446744073709551615})";
  const auto back = parse_result(to_json(StoredResult{.position = 5, .final = true, .dwell = dwell}));
  ASSERT_TRUE(back) << back.error();
  EXPECT_EQ(back->position, 5U);
  EXPECT_TRUE(back->final);
  EXPECT_EQ(back->dwell, dwell);
}

TEST(RunEntries, MembersThatAreNotKnownAreLeftAlone) {
  EXPECT_TRUE(parse_run_end(R"({"why":"w","records":1,"samples":1,"utc":"u","new":{"a":[1]}})"));
}

std::string header_error(const std::string& path, const nlohmann::json& value) {
  nlohmann::json json = nlohmann::json::parse(to_json(full_header()));
  json[nlohmann::json::json_pointer(path)] = value;
  const auto parsed = parse_run_header(json.dump());
  return parsed ? "" : parsed.error();
}

TEST(RunEntries, WhatIsWrongIsNamedWithItsPlace) {
  EXPECT_EQ(header_error("/run", -1), "run entry: \"run\" is no whole number from 0 to 9223372036854775807");
  EXPECT_EQ(header_error("/person/uid", 4294967296),
            "run entry: \"person.uid\" is no whole number from 0 to 4294967295");
  EXPECT_EQ(header_error("/files/0/base64", "?"), "run entry: \"files[0].base64\" is not base64");
  EXPECT_EQ(header_error("/channels/1", 7), "run entry: \"channels[1]\" is no text");
  EXPECT_EQ(header_error("/origin", 7), "run entry: \"origin\" is no object");
  EXPECT_EQ(header_error("/plugins", 7), "run entry: \"plugins\" is no array");
  EXPECT_EQ(parse_run_end(R"({"why":"w"})").error(), "end entry: \"records\" is missing");
  EXPECT_EQ(parse_run_end("{\"why\":").error(), "end entry: it is not JSON at byte 8");
  EXPECT_EQ(parse_run_end("[]").error(), "end entry: it is no object");
  EXPECT_EQ(parse_result(R"({"position":1,"final":true})").error(), "result entry: \"dwell\" is no object");
}

TEST(RunEntries, AHostileBodyIsAnError) {
  const std::string deep = R"({"position":1,"final":true,"dwell":{"a":)" + std::string(1'000'000, '[');
  EXPECT_EQ(parse_result(deep).error(), "result entry: it nests deeper than 64");
  EXPECT_EQ(parse_event(std::string((8 << 20) + 1, ' ')).error(),
            "event entry: it holds 8388609 bytes: at most 8388608 are allowed");
  EXPECT_FALSE(parse_event("{\"position\":1e999}"));
  EXPECT_EQ(parse_model("estimate", R"({"position":1,"utc":"","from":{},"result":null})").error(),
            "estimate entry: \"result\" is no object");
  EXPECT_FALSE(parse_event(std::string("\xFF\xFE\0{", 4)));
  std::mt19937_64 random(3);
  const std::string body = to_json(full_header());
  for (int k = 0; k < 3000; ++k) {  // whatever is read can be written and read again
    std::string other = body;
    for (std::size_t n = 1 + random() % 3; n > 0; --n) other[random() % other.size()] = static_cast<char>(random());
    const auto parsed = parse_run_header(other);
    if (parsed) {
      EXPECT_TRUE(parse_run_header(to_json(*parsed))) << k;
    } else {
      EXPECT_EQ(parsed.error().find('\n'), std::string::npos) << k;
    }
  }
}

TEST(Origin, NamesWhatMakesTheSameBits) {
  const Origin origin = this_origin();
  EXPECT_NE(origin.version.find("0."), std::string::npos) << origin.version;
  EXPECT_NE(origin.build.find("glibc 2."), std::string::npos) << origin.build;
  EXPECT_NE(origin.build.find("Eigen 3."), std::string::npos) << origin.build;
  EXPECT_FALSE(origin.cpu.empty());
  EXPECT_FALSE(origin.host.empty());
  EXPECT_TRUE(std::isnan(origin.clock_error_s) ? !origin.clock_synchronized : origin.clock_error_s >= 0);
  EXPECT_EQ(this_origin().build, origin.build);
}

TEST(RunEntries, EventsStandAsTheyHappened) {
  std::vector<StoredEvent> events(4);
  const std::uint64_t positions[] = {9, 4, 9, 1};
  for (std::size_t i = 0; i < events.size(); ++i) {
    events[i].position = positions[i];
    events[i].text = std::to_string(i);
  }
  sort_by_place(events);
  std::string order;
  for (const StoredEvent& event : events) order += event.text;
  EXPECT_EQ(order, "3102");
}

}  // namespace
}  // namespace dwell::record
