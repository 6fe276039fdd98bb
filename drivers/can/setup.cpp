#include "drivers/can/setup.hpp"

#include <algorithm>
#include <cstdio>
#include <optional>

#include "drivers/can/dbc.hpp"
#include "drivers/socketcan/socket.hpp"

namespace dwell::can {
namespace {

using driver::ChannelSettings;
using driver::flag_key;
using driver::integer_key;
using driver::real_key;
using driver::required;
using driver::text_key;

constexpr double kTimeout_s = 1.0, kMostTimeout_s = 60.0;
constexpr double kCyclesToTimeout = 3.5;

constexpr dwell_key kKeys[] = {
    required(text_key(DWELL_DEVICE, "interface", nullptr, "the CAN interface, for instance can0; or unix:PATH")),
    text_key(DWELL_DEVICE, "dbc", nullptr, "the DBC file that says where the signals are"),
    flag_key(DWELL_DEVICE, "j1939",
             "take every extended message of the DBC file by its parameter group; default as the file says"),
    text_key(DWELL_DEVICE, "stamps", "hardware|kernel",
             "whose stamps frames are given: the interface's own if it has them (default), or the kernel's"),
    real_key(
        DWELL_DEVICE, "timeout", 0.01, kMostTimeout_s, "s",
        "after which a channel without a frame is stale; default 1, or 3.5 cycles if the DBC file says a longer one"),
    text_key(DWELL_CHANNEL, "message", nullptr, "the message, by the DBC file's name"),
    text_key(DWELL_CHANNEL, "signal", nullptr, "the signal, by the DBC file's name"),
    integer_key(DWELL_CHANNEL, "id", 0, 0x1FFFFFFF, "", "without a DBC file: the message's identifier"),
    flag_key(DWELL_CHANNEL, "extended", "the identifier has 29 bits; default: if it is above 0x7FF"),
    integer_key(DWELL_CHANNEL, "pgn", 0, 0x3FFFF, "", "without a DBC file, instead of id: the J1939 parameter group"),
    integer_key(DWELL_CHANNEL, "source", 0, 255, "", "J1939: the source address; default any"),
    integer_key(DWELL_CHANNEL, "start", 0, 511, "", "without a DBC file: the signal's first bit, as DBC files count"),
    integer_key(DWELL_CHANNEL, "length", 1, 64, "", "without a DBC file: the signal's length in bits"),
    text_key(DWELL_CHANNEL, "order", "intel|motorola", "without a DBC file: the order of bytes; default intel"),
    text_key(DWELL_CHANNEL, "type", "unsigned|signed|float", "without a DBC file: what the bits are; default unsigned"),
};

constexpr const char* kByDbc[] = {"message", "signal"};
constexpr const char* kByHand[] = {"id", "extended", "pgn", "start", "length", "order", "type"};

std::string hex(std::uint32_t value) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%X", value);
  return text;
}

std::string shown(const Match& match) {
  if (!match.j1939) return "id " + hex(match.id) + (match.extended ? ", extended" : "");
  return "PGN " + std::to_string(group_of(match.id)) +
         (match.source < 0 ? "" : " from address " + std::to_string(match.source));
}

// "; nearest: Force, Forces" or "; expected one of A, B, …"
std::string suggestion(std::string_view word, const std::vector<std::string_view>& names) {
  constexpr std::size_t kMost = 8;
  const std::vector<std::string> near = nearest(word, names);
  std::string text = near.empty() ? "; expected one of " : "; the nearest are ";
  if (near.size() == 1) text = "; the nearest is ";
  if (names.empty()) return "; it has none";
  for (std::size_t i = 0; i < (near.empty() ? std::min(names.size(), kMost) : near.size()); ++i)
    text += (i > 0 ? ", " : "") + std::string(near.empty() ? names[i] : std::string_view(near[i]));
  return text + (near.empty() && names.size() > kMost ? ", …" : "");
}

// Reads one channel after the other.
class SetupReader {
 public:
  SetupReader(const driver::Settings& settings, std::vector<Mistake>& mistakes)
      : settings_(settings), mistakes_(mistakes) {}

  Setup read() {
    Setup setup;
    setup.interface = settings_.get<std::string>("interface", "");
    setup.hardware_stamps = settings_.get<std::string_view>("stamps", "hardware") == "hardware";
    if (const std::string fault = socketcan::interface_fault(setup.interface); !fault.empty())
      wrong("interface", "`" + setup.interface + "` " + fault);
    read_file();
    const auto& channels = settings_.channels();
    for (position_ = 0; position_ < static_cast<int>(channels.size()); ++position_) {
      const ChannelSettings& channel = channels[static_cast<std::size_t>(position_)];
      Channel made;
      made.index = channel.index;
      Wanted wanted;
      const bool by_hand = given(channel, kByHand) != nullptr;
      if (by_hand ? read_by_hand(channel, made, wanted) : read_by_dbc(channel, made, wanted)) {
        made.timeout_ns = driver::to_ns(
            settings_.get<double>("timeout", std::clamp(kCyclesToTimeout * cycle_s_, kTimeout_s, kMostTimeout_s)));
        setup.channels.push_back(std::move(made));
        setup.wanted.push_back(std::move(wanted));
      }
    }
    return setup;
  }

 private:
  void wrong(const char* key, std::string text) { mistakes_.push_back({position_, key, std::move(text)}); }

  template <std::size_t N>
  static const char* given(const ChannelSettings& channel, const char* const (&names)[N]) {
    for (const char* name : names)
      if (channel.has(name)) return name;
    return nullptr;
  }

  void read_file() {
    const auto name = settings_.get<std::string>("dbc");
    if (!name) {
      if (settings_.has("j1939")) wrong("j1939", "`j1939` speaks of a DBC file; expected `dbc` as well");
      return;
    }
    file_ = *name;
    DbcResult read = read_dbc(settings_.path(*name));
    if (read) {
      dbc_ = std::move(*read);
    } else {
      for (const DbcMistake& each : read.error()) wrong("dbc", to_string(file_, each));
    }
    if (dbc_ && settings_.has("j1939"))
      for (Message& message : dbc_->messages) message.j1939 = message.extended && settings_.get<bool>("j1939", false);
  }

  // false: told what is wrong.
  bool read_by_dbc(const ChannelSettings& channel, Channel& made, Wanted& wanted) {
    const auto message_name = channel.get<std::string_view>("message"),
               signal_name = channel.get<std::string_view>("signal");
    if (!message_name || !signal_name) {
      const bool neither = !message_name && !signal_name;
      wrong(message_name  ? "message"
            : signal_name ? "signal"
                          : nullptr,
            neither
                ? "nothing says where the reading is; expected `message` and `signal`, or `id`, `start` and `length`"
                : std::string("`") + (message_name ? "signal" : "message") + "` is missing; expected both");
      return false;
    }
    if (!settings_.has("dbc")) {
      wrong("message", "a message by name needs a DBC file; expected `dbc` in the device's table");
      return false;
    }
    if (!dbc_) return false;  // told
    const Message* const message = find_message(*message_name);
    const Signal* const signal = message != nullptr ? find_signal(*message, *signal_name) : nullptr;
    if (signal == nullptr) return false;
    if (message->j1939 && message->length > CAN_MAX_DLEN) {
      wrong("message", "message `" + message->name + "` of " + file_ + " has " + std::to_string(message->length) +
                           " bytes, which J1939 sends in several frames; expected at most 8");
      return false;
    }
    wanted.match = {message->id, message->extended, message->j1939, -1};
    wanted.field = signal->field;
    wanted.factor = signal->factor;
    wanted.offset = signal->offset;
    cycle_s_ = message->cycle_s;
    for (const Signal* at = signal; at->multiplexed; at = &message->signals[at->selector])
      wanted.conditions.push_back({message->signals[at->selector].field, at->selected_by});
    if (!read_source(channel, wanted.match) || !is_one(*message, wanted.match)) return false;
    made.source = message->name + "." + signal->name + " (" + shown(wanted.match) + ")";
    return true;
  }

  // Where the file has the group from several addresses, the name alone would read whichever device sends.
  bool is_one(const Message& message, const Match& match) {
    if (!message.j1939 || match.source >= 0) return true;
    for (const Message& other : dbc_->messages)
      if (&other != &message && other.j1939 && group_of(other.id) == group_of(message.id)) {
        wrong("message", "message `" + message.name + "` of " + file_ + " has the parameter group of `" + other.name +
                             "`; expected `source` to say whose it is: " + std::to_string(message.id & 0xFFU) +
                             " in the file");
        return false;
      }
    return true;
  }

  const Message* find_message(std::string_view name) {
    std::vector<std::string_view> names;
    const Message* found = nullptr;
    for (const Message& message : dbc_->messages) {
      if (message.name != name) {
        names.push_back(message.name);
      } else if (found == nullptr) {
        found = &message;
      } else {
        wrong("message", file_ + " has several messages `" + std::string(name) + "`; expected a name of its own");
        return nullptr;
      }
    }
    if (found != nullptr) return found;
    wrong("message", file_ + " has no message `" + std::string(name) + "`" + suggestion(name, names));
    return nullptr;
  }

  const Signal* find_signal(const Message& message, std::string_view name) {
    std::vector<std::string_view> names;
    for (const Signal& signal : message.signals) {
      if (signal.name == name && signal.unreadable.empty()) return &signal;
      if (signal.name == name) {
        wrong("signal",
              to_string(file_, {signal.line, signal.column, "signal `" + signal.name + "` " + signal.unreadable}));
        return nullptr;
      }
      names.push_back(signal.name);
    }
    wrong("signal", "message `" + message.name + "` of " + file_ + " has no signal `" + std::string(name) + "`" +
                        suggestion(name, names));
    return nullptr;
  }

  bool read_by_hand(const ChannelSettings& channel, Channel& made, Wanted& wanted) {
    const char* const by_dbc = given(channel, kByDbc);
    if (by_dbc != nullptr) {
      wrong(by_dbc, std::string("`") + by_dbc + "` and `" + given(channel, kByHand) +
                        "` are two ways to say where the reading is; expected one of them");
      return false;
    }
    cycle_s_ = 0.0;
    bool good = read_match(channel, wanted.match);
    for (const char* key : {"start", "length"})
      if (!channel.has(key)) {
        wrong(given(channel, kByHand), std::string("`") + key + "` is missing; expected it beside the identifier");
        good = false;
      }
    good = read_source(channel, wanted.match) && good;
    if (!good || !read_field(channel, wanted.field)) return false;
    made.source = shown(wanted.match) + ", bit " + std::to_string(wanted.field.start);
    return true;
  }

  bool read_match(const ChannelSettings& channel, Match& match) {
    const auto id = channel.get<std::uint32_t>("id"), group = channel.get<std::uint32_t>("pgn");
    const bool extended = channel.get<bool>("extended", group || (id && *id > CAN_SFF_MASK));
    if (id.has_value() == group.has_value()) {
      wrong(id ? "pgn" : given(channel, kByHand),
            id ? "`id` and `pgn` are two ways to name a message; expected one of them"
               : "`id` or `pgn` is missing; expected one of them");
      return false;
    }
    if (group && !extended) {
      wrong("extended", "J1939 has 29-bit identifiers alone; expected true");
      return false;
    }
    if (group && group_of(*group << 8U) != *group) {
      wrong("pgn", "PGN " + std::to_string(*group) + " is sent to a destination, which is no part of it; expected " +
                       std::to_string(group_of(*group << 8U)));
      return false;
    }
    if (id && !extended && *id > CAN_SFF_MASK) {
      wrong("id", "identifier " + hex(*id) + " has more than 11 bits; expected at most 0x7FF, or extended = true");
      return false;
    }
    match = {group ? *group << 8U : *id, extended, group.has_value(), -1};
    return true;
  }

  bool read_source(const ChannelSettings& channel, Match& match) {
    const auto source = channel.get<int>("source");
    if (!source) return true;
    if (!match.j1939) {
      wrong("source", "only J1939 messages have a source address; expected `pgn`, or a J1939 message of the DBC file");
      return false;
    }
    match.source = *source;
    return true;
  }

  bool read_field(const ChannelSettings& channel, Field& field) {
    const auto type = channel.get<std::string_view>("type", "unsigned");
    field.start = channel.get<std::uint16_t>("start", 0);
    field.length = channel.get<std::uint8_t>("length", 1);
    field.order = channel.get<std::string_view>("order", "intel") == "motorola" ? Order::motorola : Order::intel;
    field.form = type == "signed" ? Form::signed_integer : Form::unsigned_integer;
    if (type == "float") {
      if (field.length != 32 && field.length != 64) {
        wrong("length", "a float of " + std::to_string(field.length) + " bits; expected 32 or 64");
        return false;
      }
      field.form = field.length == 32 ? Form::float32 : Form::float64;
    }
    if (bytes_of(field) > kMostBytes) {
      wrong("start", "the signal ends in byte " + std::to_string(bytes_of(field)) + "; expected it within " +
                         std::to_string(kMostBytes));
      return false;
    }
    return true;
  }

  const driver::Settings& settings_;
  std::vector<Mistake>& mistakes_;
  int position_ = -1;  // of the channel being read
  std::string file_;
  std::optional<Dbc> dbc_;
  double cycle_s_ = 0.0;  // of the message found last
};

}  // namespace

std::span<const dwell_key> keys() noexcept { return kKeys; }

Setup read_setup(const driver::Settings& settings, std::vector<Mistake>& mistakes) {
  return SetupReader(settings, mistakes).read();
}

Setup read_setup(const driver::Settings& settings) {
  std::vector<Mistake> mistakes;
  Setup setup = read_setup(settings, mistakes);
  socketcan::refuse(mistakes);
  return setup;
}

}  // namespace dwell::can
