// can_table DBC: what the DBC parser and the frame decoder make of the frames on standard input, for another program to
// compare with. A line in: identifier (hexadecimal, bit 31 set if extended) and data (hexadecimal); the line's answer
// is a line "frame" and one line for each signal in it: message, signal, what its bits are, the physical value.
#include <charconv>
#include <cstdio>
#include <iostream>
#include <string>

#include "drivers/can/dbc.hpp"
#include "drivers/can/decoder.hpp"

using namespace dwell::can;

namespace {

struct Entry {
  const Message* message;
  const Signal* signal;
};

void print(const Entry& entry, const Reading& reading, const std::uint8_t* data) {
  const Field& field = entry.signal->field;
  const std::uint64_t bits = bits_of(data, field);
  std::printf("%s %s ", entry.message->name.c_str(), entry.signal->name.c_str());
  if (field.form == Form::unsigned_integer) {
    std::printf("%llu", static_cast<unsigned long long>(bits));
  } else if (field.form == Form::signed_integer) {
    const unsigned unused = 64U - field.length;
    std::printf("%lld", static_cast<long long>(static_cast<std::int64_t>(bits << unused) >> unused));
  } else {
    std::printf("%.17g", number_of(bits, field));
  }
  if (reading.verdict == Verdict::value)
    std::printf(" %.17g\n", reading.value);
  else
    std::printf(" %s\n", reading.verdict == Verdict::invalid ? "invalid" : "short");
}

}  // namespace

int main(int argc, char** argv) {
  const DbcResult dbc = read_dbc(argc > 1 ? argv[1] : "");
  if (!dbc) {
    for (const DbcMistake& mistake : dbc.error()) std::fprintf(stderr, "%s\n", to_string(argv[1], mistake).c_str());
    return 2;
  }
  std::vector<Entry> entries;
  std::vector<Wanted> wanted;
  for (const Message& message : dbc->messages) {
    for (const Signal& signal : message.signals) {
      entries.push_back({&message, &signal});
      wanted.push_back(
          {{message.id, message.extended, message.j1939, -1}, signal.field, signal.factor, signal.offset, {}});
      for (const Signal* at = &signal; at->multiplexed; at = &message.signals[at->selector])
        wanted.back().conditions.push_back({message.signals[at->selector].field, at->selected_by});
    }
  }
  Decoder decoder(std::move(wanted));
  for (std::string id, data; std::cin >> id >> data;) {
    canfd_frame frame{};
    std::from_chars(id.data(), id.data() + id.size(), frame.can_id, 16);
    for (std::size_t i = 0; i + 1 < data.size() && frame.len < kMostBytes; i += 2)
      std::from_chars(&data[i], &data[i] + 2, frame.data[frame.len++], 16);
    std::puts("frame");
    for (const Reading& reading : decoder.decode(frame))
      if (reading.verdict != Verdict::absent) print(entries[reading.wanted], reading, frame.data);
  }
  return 0;
}
