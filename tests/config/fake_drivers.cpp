#include "tests/config/fake_drivers.hpp"

#include <gtest/gtest.h>

#include <iterator>

namespace dwell::config::testing {
namespace {

constexpr double kNone = 1.0;  // with kNoMore below: unbounded
constexpr double kNoMore = 0.0;

const dwell_key kModbusKeys[] = {
    {"transport", DWELL_DEVICE, DWELL_STRING, 1, kNone, kNoMore, "tcp|rtu", "", ""},
    {"host", DWELL_DEVICE, DWELL_STRING, 0, kNone, kNoMore, nullptr, "", ""},
    {"port", DWELL_DEVICE, DWELL_INTEGER, 0, 1, 65535, nullptr, "", ""},
    {"serial", DWELL_DEVICE, DWELL_STRING, 0, kNone, kNoMore, nullptr, "", ""},
    {"baud", DWELL_DEVICE, DWELL_INTEGER, 0, 300, 4000000, nullptr, "", ""},
    {"parity", DWELL_DEVICE, DWELL_STRING, 0, kNone, kNoMore, "none|even|odd", "", ""},
    {"stop_bits", DWELL_DEVICE, DWELL_INTEGER, 0, 1, 2, nullptr, "", ""},
    {"rate", DWELL_DEVICE, DWELL_REAL, 0, 0.001, 10000, nullptr, "Hz", ""},
    {"rate_shift", DWELL_DEVICE, DWELL_BOOLEAN, 0, kNone, kNoMore, nullptr, "", ""},
    {"timeout", DWELL_DEVICE, DWELL_REAL, 0, 0.001, 60, nullptr, "s", ""},
    {"station", DWELL_CHANNEL, DWELL_INTEGER, 0, 0, 255, nullptr, "", ""},
    {"table", DWELL_CHANNEL, DWELL_STRING, 0, kNone, kNoMore, "input|holding", "", ""},
    {"register", DWELL_CHANNEL, DWELL_INTEGER, 1, 0, 65535, nullptr, "", ""},
    {"type", DWELL_CHANNEL, DWELL_STRING, 1, kNone, kNoMore, "int16|uint16|int32|uint32|float32|float64", "", ""},
    {"order", DWELL_CHANNEL, DWELL_STRING, 0, kNone, kNoMore, "abcd|cdab|badc|dcba", "", ""},
};
const dwell_key kReplayKeys[] = {
    {"file", DWELL_DEVICE, DWELL_STRING, 1, kNone, kNoMore, nullptr, "", ""},
    {"speed", DWELL_DEVICE, DWELL_REAL, 0, 0, 1e6, nullptr, "", ""},
    {"column", DWELL_CHANNEL, DWELL_STRING, 0, kNone, kNoMore, nullptr, "", ""},
};
const dwell_key kPickyKeys[] = {
    {"word", DWELL_DEVICE, DWELL_STRING, 0, kNone, kNoMore, nullptr, "", ""},
    {"flag", DWELL_DEVICE, DWELL_BOOLEAN, 0, kNone, kNoMore, nullptr, "", ""},
    {"count", DWELL_DEVICE, DWELL_INTEGER, 0, kNone, kNoMore, nullptr, "", ""},
    {"level", DWELL_DEVICE, DWELL_REAL, 0, kNone, kNoMore, nullptr, "V", ""},
    {"wire", DWELL_CHANNEL, DWELL_STRING, 0, kNone, kNoMore, nullptr, "", ""},
};

void object_to_odd(const dwell_entry* entries, std::size_t count, int32_t channel, dwell_report report, void* context) {
  for (std::size_t i = 0; i < count; ++i) {
    if (entries[i].string != nullptr && std::string_view(entries[i].string) == "odd") {
      report(context, channel, entries[i].key, "this is odd: expected something even");
    }
  }
}

void picky_check(const dwell_settings* settings, dwell_report report, void* context) {
  object_to_odd(settings->entries, settings->entry_count, -1, report, context);
  for (std::size_t i = 0; i < settings->channel_count; ++i) {
    const dwell_channel& channel = settings->channels[i];
    object_to_odd(channel.entries, channel.entry_count, static_cast<int32_t>(i), report, context);
  }
  if (settings->channel_count == 0) report(context, -1, nullptr, "no channel: expected at least one");
}

// 100 polls per second unless stated, answered within 0.15 s.
void modbus_describe(const dwell_settings* settings, dwell_traits* traits) {
  traits->rate_hz = 100;
  traits->rate_may_shift = 1;
  traits->age_ns = 150'000'000;
  for (std::size_t i = 0; i < settings->entry_count; ++i) {
    const dwell_entry& entry = settings->entries[i];
    if (std::string_view(entry.key) == "rate") traits->rate_hz = entry.real;
    if (std::string_view(entry.key) == "rate_shift") traits->rate_may_shift = entry.boolean;
  }
}

template <std::size_t size>
dwell_driver_table table(const char* name, const dwell_key (&keys)[size],
                         void (*check)(const dwell_settings*, dwell_report, void*),
                         void (*describe)(const dwell_settings*, dwell_traits*) = nullptr) {
  dwell_driver_table out{};
  out.size = sizeof out;
  out.abi = DWELL_DRIVER_ABI;
  out.name = name;
  out.version = "0";
  out.help = "";
  out.keys = keys;
  out.key_count = size;
  out.key_size = sizeof(dwell_key);
  out.check = check;
  out.describe = describe;
  return out;
}

const dwell_driver_table kTables[] = {table("modbus", kModbusKeys, nullptr, modbus_describe),
                                      table("replay", kReplayKeys, nullptr), table("picky", kPickyKeys, picky_check)};

}  // namespace

SchemaSource fake_schemas() {
  return [](std::string_view driver) -> tl::expected<const dwell_driver_table*, std::string> {
    for (const dwell_driver_table& known : kTables) {
      if (driver == known.name) return &known;
    }
    return tl::make_unexpected(std::string("expected one of modbus, replay, picky"));
  };
}

const std::string_view kGoodRig = R"([rig]
name = "bench"
motion = "translation"
boundary = "clamped"
masses = [12.0, 8.0]
mass_u = [0.01, 0.02]

[excitation]
frequency = 4.0
frequency_u = 0.0002
clock_u = 4e-5
minimum = 2e-5
search = [3.9, 4.1]
reference = "fixed"
harmonics = 4

[settling]
tolerance = 0.01

[estimation]
memory = 300
update = 0.2

[server]
listen = "[::1]:9000"

[recording]
directory = "runs"

[[device]]
name = "amplifier"
driver = "modbus"
transport = "tcp"
host = "127.0.0.1"
port = 1502
rate = 500
delay = 0.001
delay_u = 1e-4

[[device]]
name = "bus"
driver = "picky"
word = "even"

[[channel]]
name = "y0"
device = "amplifier"
measures = "displacement"
at = 0
unit = "mm"
scale = -2.0
offset = 0.5
delay = 0.0004
delay_u = 2e-5
lowpass = { type = "butterworth", order = 2, hz = 250, hz_u = 5.0 }
highpass = { type = "rc", order = 1, hz = 0.5 }
range = [-10.0, 10.0]
calibration = { id = "K-2231", due = 2027-03-31 }
scale_u = 0.001
register = 0
type = "float32"

[[channel]]
name = "a1"
device = "amplifier"
measures = "acceleration"
at = 1
unit = "g"
register = 2
type = "float32"

[[channel]]
name = "d2"
device = "amplifier"
measures = "displacement"
at = 2
relative_to = 1
unit = "in"
register = 4
type = "float32"

[[channel]]
name = "reaction"
device = "bus"
measures = "force"
at = "ground"
positive = "mass"
unit = "kN"
wire = "even"
)";

Edited edited(std::string_view old_text, std::string_view new_text) {
  Edited out{std::string(kGoodRig), {}};
  std::size_t at = out.text.size();
  if (!old_text.empty()) {
    at = out.text.find(old_text);
    EXPECT_NE(at, std::string::npos) << "the good rig has no " << old_text;
    EXPECT_EQ(out.text.find(old_text, at + 1), std::string::npos) << old_text << " stands there twice";
    if (at == std::string::npos) return out;
  }
  out.text.replace(at, old_text.size(), new_text);
  const std::size_t mark = out.text.find('@');
  if (mark == std::string::npos) return out;
  out.text.erase(mark, 1);
  out.position = {1, 1};
  for (std::size_t i = 0; i < mark; ++i) {
    out.position =
        out.text[i] == '\n' ? Position{out.position.line + 1, 1} : Position{out.position.line, out.position.column + 1};
  }
  return out;
}

std::string mistakes_in(std::string_view text, const SchemaSource& schemas) {
  const Result<RigFile> file = parse(text, "rig.toml", schemas);
  return file ? std::string() : to_string("rig.toml", file.error());
}

void expect_mistake(std::string_view old_text, std::string_view new_text, const std::string& message,
                    const SchemaSource& schemas) {
  const Edited edit = edited(old_text, new_text);
  EXPECT_EQ(mistakes_in(edit.text, schemas),
            to_string("rig.toml", Mistake{edit.position.line, edit.position.column, message}) + "\n")
      << "after the edit to: " << new_text;
}

void expect_good(std::string_view old_text, std::string_view new_text, const SchemaSource& schemas) {
  EXPECT_EQ(mistakes_in(edited(old_text, new_text).text, schemas), "") << "after the edit to: " << new_text;
}

}  // namespace dwell::config::testing
