#include "drivers/modbus/setup.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <map>
#include <string_view>
#include <tuple>

namespace dwell::modbus {
namespace {

using driver::ChannelSettings;
using driver::flag_key;
using driver::integer_key;
using driver::real_key;
using driver::required;
using driver::text_key;

// What libmodbus can set (any other rate it takes silently for 9600) and what is fast enough to carry the shortest
// answer within kLongestAnswer_ns.
constexpr std::array kBauds = {600,     1200,    2400,    4800,    9600,    19200,  38400,   57600,
                               115200,  230400,  460800,  500000,  576000,  921600, 1000000, 1152000,
                               1500000, 2000000, 2500000, 3000000, 3500000, 4000000};

// An answer is received in one uninterruptible call: on slow lines it is kept short, so that stop can outlast it.
constexpr std::int64_t kLongestAnswer_ns = 300'000'000;

constexpr dwell_key kKeys[] = {
    required(text_key(DWELL_DEVICE, "transport", "tcp|rtu", "Modbus TCP, or RTU on a serial line")),
    text_key(DWELL_DEVICE, "host", nullptr, "tcp: address or name of the device"),
    integer_key(DWELL_DEVICE, "port", 1, 65535, "", "tcp: port; default 502"),
    text_key(DWELL_DEVICE, "serial", nullptr, "rtu: the serial port, for instance /dev/ttyUSB0"),
    integer_key(DWELL_DEVICE, "baud", 600, 4000000, "", "rtu: bits per second; default 19200"),
    text_key(DWELL_DEVICE, "parity", "none|even|odd", "rtu: parity; default even"),
    integer_key(DWELL_DEVICE, "stop_bits", 1, 2, "", "rtu: stop bits; default 1"),
    real_key(DWELL_DEVICE, "gap", 0.0, 1.0, "s",
             "rtu: silence between frames; default 3.5 characters, above 19200 baud 1.75 ms"),
    real_key(DWELL_DEVICE, "rate", 0.01, 1e6, "Hz", "polls per second; default 100"),
    flag_key(DWELL_DEVICE, "rate_shift",
             "whether the rate may be shifted by up to 1 %, so that harmonics of the drive do not read as others; "
             "default true"),
    real_key(DWELL_DEVICE, "timeout", 0.001, 5.0, "s",
             "how long an answer may take, its time on the wire apart; default 0.1"),
    real_key(DWELL_DEVICE, "late", 0.0, 60.0, "s", "rtu: silence after a missing or bad answer; default 5 timeouts"),
    integer_key(DWELL_DEVICE, "max_registers", 4, kMaxRegisters, "",
                "registers read in one transaction at most; default 125"),
    integer_key(DWELL_CHANNEL, "station", 0, 255, "", "unit id; default 1"),
    text_key(DWELL_CHANNEL, "table", "input|holding", "which registers; default input"),
    required(integer_key(DWELL_CHANNEL, "register", 0, 65535, "", "the value's first register, counted from 0")),
    required(text_key(DWELL_CHANNEL, "type", "int16|uint16|int32|uint32|float32|float64", "what the registers hold")),
    text_key(DWELL_CHANNEL, "order", "abcd|cdab|badc|dcba", "order of the value's bytes; default abcd"),
};

template <class T, std::size_t N>
T one_of(std::string_view word, const std::array<std::string_view, N>& words, T first) {
  const auto place = std::find(words.begin(), words.end(), word);
  return place == words.end() ? first : static_cast<T>(std::distance(words.begin(), place));
}

Reading read_channel(const ChannelSettings& channel) {
  static constexpr std::array<std::string_view, 6> kTypes = {"int16",  "uint16",  "int32",
                                                             "uint32", "float32", "float64"};
  static constexpr std::array<std::string_view, 4> kOrders = {"abcd", "cdab", "badc", "dcba"};
  Reading reading;
  reading.index = channel.index;
  reading.station = static_cast<std::uint8_t>(channel.get<int>("station", 1));
  reading.table = channel.get<std::string_view>("table", "input") == "holding" ? Table::holding : Table::input;
  reading.first = static_cast<std::uint16_t>(channel.get<int>("register", 0));
  reading.type = one_of(channel.get<std::string_view>("type", "int16"), kTypes, Type::int16);
  reading.order = one_of(channel.get<std::string_view>("order", "abcd"), kOrders, Order::abcd);
  return reading;
}

}  // namespace

std::string Setup::address() const { return transport == Transport::tcp ? host + ":" + std::to_string(port) : serial; }

std::span<const dwell_key> keys() noexcept { return kKeys; }

Setup read_setup(const driver::Settings& settings) {
  Setup setup;
  setup.transport = settings.get<std::string_view>("transport", "tcp") == "rtu" ? Transport::rtu : Transport::tcp;
  setup.host = settings.get<std::string>("host", "");
  setup.port = settings.get<int>("port", 502);
  setup.serial = settings.get<std::string>("serial", "");
  setup.baud = settings.get<int>("baud", 19200);
  const auto parity = settings.get<std::string_view>("parity", "even");
  setup.parity = parity == "none" ? 'N' : parity == "odd" ? 'O' : 'E';
  setup.stop_bits = settings.get<int>("stop_bits", 1);
  setup.timeout_ns = driver::to_ns(settings.get<double>("timeout", 0.1));
  setup.rate_hz = settings.get<double>("rate", 100.0);
  auto max_registers = settings.get<unsigned>("max_registers", kMaxRegisters);
  if (setup.transport == Transport::rtu) {
    setup.wire.baud = setup.baud;
    setup.wire.bits_per_character = 9.0 + (setup.parity == 'N' ? 0.0 : 1.0) + setup.stop_bits;
    const std::int64_t characters_ns = setup.wire.time_ns(7) / 2;
    const auto gap = settings.get<double>("gap");
    setup.gap_ns = gap ? driver::to_ns(*gap) : setup.baud > 19200 ? 1'750'000 : characters_ns;
    const auto late = settings.get<double>("late");
    setup.late_ns = late ? driver::to_ns(*late) : 5 * setup.timeout_ns;
    while (max_registers > 4 && setup.wire.time_ns(answer_bytes(max_registers)) > kLongestAnswer_ns) --max_registers;
  }
  std::vector<Reading> readings;
  for (const ChannelSettings& channel : settings.channels()) readings.push_back(read_channel(channel));
  setup.blocks = plan(std::move(readings), max_registers);
  return setup;
}

std::int64_t greatest_age_ns(const Setup& setup) noexcept {
  std::int64_t wire_ns = 0;
  for (const Block& block : setup.blocks) wire_ns = std::max(wire_ns, setup.wire.time_ns(answer_bytes(block.count)));
  return setup.timeout_ns + wire_ns;
}

double most_rate_hz(const Setup& setup) noexcept {
  if (setup.transport != Transport::rtu) return 0.0;
  std::int64_t poll_ns = 0;
  for (const Block& block : setup.blocks)
    poll_ns += setup.wire.time_ns(kRequestBytes + answer_bytes(block.count)) + setup.gap_ns;
  return poll_ns > 0 ? 1e9 / static_cast<double>(poll_ns) : 0.0;
}

void check_setup(const driver::Settings& settings, driver::Report& report) {
  const bool rtu = settings.get<std::string_view>("transport", "") == "rtu";
  const auto needs = [&](const char* key, const char* example) {
    if (settings.get<std::string_view>(key, "").empty())
      report.device(settings.has(key) ? key : "transport",
                    std::string("`") + key + "` is missing; expected " + example);
  };
  const auto foreign = [&](std::initializer_list<const char*> names, const char* transport) {
    for (const char* key : names)
      if (settings.has(key)) report.device(key, std::string("`") + key + "` is for transport = \"" + transport + "\"");
  };
  if (rtu) {
    needs("serial", "the serial port, for instance \"/dev/ttyUSB0\"");
    foreign({"host", "port"}, "tcp");
    const int baud = settings.get<int>("baud", 19200);
    if (std::find(kBauds.begin(), kBauds.end(), baud) == kBauds.end()) {
      std::string bauds;
      for (const int known : kBauds) bauds += (bauds.empty() ? "" : ", ") + std::to_string(known);
      report.device("baud", "no serial port runs at " + std::to_string(baud) + " baud; expected one of " + bauds);
    }
  } else {
    needs("host", "the device's address, for instance \"192.168.0.10\"");
    foreign({"serial", "baud", "parity", "stop_bits", "gap", "late"}, "rtu");
  }
  std::map<std::tuple<std::uint8_t, Table, unsigned>, std::size_t> readers;  // of each register the first channel
  for (std::size_t i = 0; i < settings.channels().size(); ++i) {
    const Reading reading = read_channel(settings.channels()[i]);
    for (unsigned number = reading.first; number < std::min(reading.end(), 65536U); ++number) {
      const auto [first, fresh] = readers.try_emplace({reading.station, reading.table, number}, i);
      if (fresh || reading.end() > 65536) continue;
      report.channel(i, "register",
                     "register " + std::to_string(number) + " (station " + std::to_string(reading.station) + ", " +
                         (reading.table == Table::input ? "input" : "holding") + ") is read by channel \"" +
                         std::string(settings.channels()[first->second].name) +
                         "\" already; expected registers of its own");
      break;
    }
    if (reading.end() > 65536)
      report.channel(i, "register",
                     "the value ends beyond register 65535; expected at most " +
                         std::to_string(65536 - registers_of(reading.type)) + " for its type");
    if (rtu && (reading.station < 1 || reading.station > 247))
      report.channel(i, settings.channels()[i].has("station") ? "station" : nullptr,
                     "station " + std::to_string(reading.station) + " cannot be on a serial line; expected 1 to 247");
  }
}

}  // namespace dwell::modbus
