// What joins a DBC file's statements once all have been read: floats, multiplexors, frame formats.
#include <algorithm>
#include <charconv>

#include "drivers/can/dbc_parser.hpp"

namespace dwell::can {
namespace {

// VFrameFormat of J1939 messages, in the enumeration that all tools use.
constexpr std::string_view kJ1939 = "J1939PG", kJ1939Number = "3";

}  // namespace

void DbcParser::link() {
  for (const FloatStatement& each : floats_) link_float(each);
  for (const SelectorStatement& each : selectors_) link_selector(each);
  for (const Multiplexed& each : multiplexed_) link_multiplexed(each);
  for (Message& message : dbc_.messages)
    for (Signal& signal : message.signals)
      if (signal.unreadable.empty() && bytes_of(signal.field) > kMostBytes)
        signal.unreadable = "lies beyond the 64 bytes that one frame has";
  if (mistakes_.empty())
    for (const Multiplexed& each : multiplexed_) {
      check_nesting(each);
      check_values(each);
    }
  link_formats();
}

std::optional<std::size_t> DbcParser::find_message(const Token& id) {
  std::uint64_t value = 0;
  std::from_chars(id.text.data(), id.text.data() + id.text.size(), value);
  if (const auto place = by_id_.find(value); place != by_id_.end()) return place->second;
  if (value != 0xC0000000U)
    mistake(id, "no message has the identifier " + std::string(id.text) + "; expected one of BO_");
  return std::nullopt;
}

std::optional<std::size_t> DbcParser::find_signal(std::size_t message, const Token& name) {
  if (const auto place = by_name_.find({message, name.text}); place != by_name_.end()) return place->second;
  mistake(name,
          "message `" + dbc_.messages[message].name + "` has no signal " + name.shown() + "; expected one of its SG_");
  return std::nullopt;
}

void DbcParser::link_float(const FloatStatement& each) {
  const auto message = find_message(each.message);
  const auto signal = message ? find_signal(*message, each.signal) : std::nullopt;
  if (!signal || each.type == 0) return;
  Field& field = dbc_.messages[*message].signals[*signal].field;
  const unsigned bits = each.type == 1 ? 32 : 64;
  if (each.type == 3) {
    mistake(each.signal,
            "signal " + each.signal.shown() + " is of type 3; expected 0 integer, 1 float of 32, 2 of 64 bits");
  } else if (field.length != bits) {
    mistake(each.signal, "signal " + each.signal.shown() + " has " + std::to_string(field.length) +
                             " bits; expected a float of " + std::to_string(bits) + " to have as many");
  } else {
    field.form = each.type == 1 ? Form::float32 : Form::float64;
  }
}

void DbcParser::link_selector(const SelectorStatement& each) {
  const auto message = find_message(each.message);
  const auto signal = message ? find_signal(*message, each.signal) : std::nullopt;
  const auto selector = signal ? find_signal(*message, each.selector) : std::nullopt;
  if (!selector) return;
  std::vector<Signal>& signals = dbc_.messages[*message].signals;
  const auto multiplexed = multiplexed_at_.find({*message, *signal});
  if (multiplexed == multiplexed_at_.end()) {
    mistake(each.signal, "signal " + each.signal.shown() + " is not multiplexed; expected m and a number in its SG_");
    return;
  }
  if (!signals[*selector].multiplexor) {
    mistake(each.selector, "signal " + each.selector.shown() + " is no multiplexor; expected M in its SG_");
    return;
  }
  Multiplexed& about = multiplexed_[multiplexed->second];
  if (about.linked && signals[*signal].selector != *selector) {
    mistake(each.selector, "signal " + each.signal.shown() + " is selected by `" +
                               signals[signals[*signal].selector].name + "` already; expected one multiplexor");
    return;
  }
  about.linked = true;
  signals[*signal].selector = *selector;
  signals[*signal].selected_by.insert(signals[*signal].selected_by.end(), each.ranges.begin(), each.ranges.end());
}

void DbcParser::link_multiplexed(const Multiplexed& each) {
  std::vector<Signal>& signals = dbc_.messages[each.message].signals;
  if (each.linked) return;
  // Of a message with very many signals this is asked for each of them.
  const auto [place, unknown] = multiplexors_.try_emplace(each.message);
  for (std::size_t i = 0; unknown && i < signals.size() && place->second.size() < 3; ++i)
    if (signals[i].multiplexor) place->second.push_back(i);
  std::vector<std::size_t> others = place->second;
  others.erase(std::remove(others.begin(), others.end(), each.signal), others.end());
  if (others.empty()) {
    mistake(each.at,
            "signal " + each.at.shown() + " is multiplexed, but its message has no multiplexor; expected one with M");
  } else if (others.size() > 1) {
    mistake(each.at,
            "signal " + each.at.shown() + " may belong to several multiplexors; expected SG_MUL_VAL_ to say to which");
  } else {
    signals[each.signal].selector = others[0];
    signals[each.signal].selected_by = {{each.value, each.value}};
  }
}

// The values that select it must fit its multiplexor.
void DbcParser::check_values(const Multiplexed& each) {
  const std::vector<Signal>& signals = dbc_.messages[each.message].signals;
  const Signal& signal = signals[each.signal];
  const Signal& selector = signals[signal.selector];
  if (!selector.unreadable.empty()) {
    mistake(each.at,
            "signal " + each.at.shown() + " is multiplexed by `" + selector.name + "`, which " + selector.unreadable);
    return;
  }
  const unsigned bits = selector.field.length;
  const std::uint64_t most = bits < 64 ? (std::uint64_t{1} << bits) - 1 : UINT64_MAX;
  for (const auto& [low, high] : signal.selected_by)
    if (low > most) {
      mistake(each.at, "signal " + each.at.shown() + " is selected by " + std::to_string(low) + ", but `" +
                           selector.name + "` has " + std::to_string(bits) + " bits; expected at most " +
                           std::to_string(most));
      return;
    }
}

void DbcParser::check_nesting(const Multiplexed& each) {
  const std::vector<Signal>& signals = dbc_.messages[each.message].signals;
  std::size_t at = each.signal;
  for (std::size_t depth = 0; signals[at].multiplexed; ++depth) {
    if (depth == kMostNesting) {
      mistake(each.at, "signal " + each.at.shown() + " is multiplexed over more than " + std::to_string(kMostNesting) +
                           " multiplexors, or by itself");
      return;
    }
    at = signals[at].selector;
    if (signals[at].field.form == Form::float32 || signals[at].field.form == Form::float64) {
      mistake(each.at, "signal " + each.at.shown() + " is multiplexed by a float; expected an integer");
      return;
    }
  }
}

bool DbcParser::is_j1939(const Token& value) const {
  if (value.kind == Token::Kind::text) return value.text == kJ1939;
  if (value.kind != Token::Kind::number) return false;
  if (format_names_.empty()) return value.text == kJ1939Number;
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(value.text.data(), value.text.data() + value.text.size(), index);
  return error == std::errc{} && end == value.text.data() + value.text.size() && index < format_names_.size() &&
         format_names_[index] == kJ1939;
}

void DbcParser::link_formats() {
  const bool otherwise = is_j1939(default_format_);
  for (Message& message : dbc_.messages) message.j1939 = message.extended && otherwise;
  for (const Frame& each : formats_)
    if (const auto place = by_id_.find(each.id); place != by_id_.end()) {
      Message& message = dbc_.messages[place->second];
      message.j1939 = message.extended && is_j1939(each.value);
    }
  for (const Frame& each : cycles_) {
    double cycle_ms = 0.0;
    std::from_chars(each.value.text.data(), each.value.text.data() + each.value.text.size(), cycle_ms);
    if (const auto place = by_id_.find(each.id); place != by_id_.end() && cycle_ms > 0.0 && cycle_ms < 1e7)
      dbc_.messages[place->second].cycle_s = 1e-3 * cycle_ms;
  }
}

}  // namespace dwell::can
