// Whatever the bytes, the DBC parser answers: messages that keep their promises, or mistakes with their places. What it
// reads can be decoded from any frame.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "drivers/can/dbc.hpp"
#include "drivers/can/decoder.hpp"

namespace {

using namespace dwell::can;

void hold(bool promise) {
  if (!promise) std::abort();
}

void check_mistakes(const std::vector<DbcMistake>& mistakes) {
  hold(!mistakes.empty() && mistakes.size() <= kMostMistakes);
  for (const DbcMistake& mistake : mistakes) {
    hold(mistake.line >= 1 && mistake.column >= 1 && !mistake.text.empty());
    hold(mistake.text.find('\n') == std::string::npos);
  }
}

void check_message(const Message& message, std::vector<Wanted>& wanted) {
  hold(message.id <= (message.extended ? 0x1FFFFFFFU : 0x7FFU) && (message.extended || !message.j1939));
  for (const Signal& signal : message.signals) {
    hold(std::isfinite(signal.factor) && std::isfinite(signal.offset));
    hold(signal.field.length >= 1 && signal.field.length <= kLongestField);
    if (!signal.unreadable.empty()) continue;
    hold(bytes_of(signal.field) <= kMostBytes && bytes_of(signal.field) <= message.length);
    wanted.push_back(
        {{message.id, message.extended, message.j1939, -1}, signal.field, signal.factor, signal.offset, {}});
    std::size_t depth = 0;
    for (const Signal* at = &signal; at->multiplexed; at = &message.signals[at->selector]) {
      hold(++depth <= kMostNesting && at->selector < message.signals.size() && !at->selected_by.empty());
      wanted.back().conditions.push_back({message.signals[at->selector].field, at->selected_by});
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const DbcResult dbc = parse_dbc({reinterpret_cast<const char*>(data), size});
  if (!dbc) {
    check_mistakes(dbc.error());
    return 0;
  }
  std::vector<Wanted> wanted;
  for (const Message& message : dbc->messages) check_message(message, wanted);
  Decoder decoder(wanted);
  canfd_frame frame{};
  for (std::size_t i = 0; i < std::min<std::size_t>(wanted.size(), 64); ++i) {
    frame.can_id = filter_of(wanted[i].match).can_id;
    frame.len = static_cast<std::uint8_t>(size % 65);
    for (std::size_t k = 0; k < kMostBytes; ++k) frame.data[k] = data[(i + k) % size];
    for (const Reading& reading : decoder.decode(frame))
      hold(reading.verdict != Verdict::value || std::isfinite(reading.value));
  }
  return 0;
}
