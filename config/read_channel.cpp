#include <sstream>

#include "config/draft.hpp"
#include "config/units.hpp"

namespace dwell::config {
namespace {

// A channel's name heads a column of a CSV file, where t, channel and value have a meaning of their own.
void read_name(Section& section, Channel& channel, std::size_t number) {
  constexpr const char* expected =
      "printable text without commas and quotes, at most 64 bytes, not t, channel or value";
  channel.name = "channel " + std::to_string(number);
  std::string name;
  if (!section.text("name", name, expected, Need::required)) return;
  const bool taken = name == "t" || name == "channel" || name == "value";
  if (taken || name.size() > 64 || name.find_first_of(",\"") != std::string::npos || name.front() == ' ' ||
      name.back() == ' ') {
    section.wrong("name", "\"name\" is " + in_quotes(name) + ": expected " + expected);
  } else {
    channel.name = name;
  }
}

std::string some_names(const std::vector<Device>& devices) {
  constexpr std::size_t most = 8;
  std::string out;
  for (std::size_t i = 0; i < devices.size() && i < most; ++i) {
    if (i > 0) out += ", ";
    out += in_quotes(devices[i].name);
  }
  if (devices.empty()) return "a [[device]] of that name";
  return devices.size() > most ? out + ", ..." : out;
}

void read_device_of(Section& section, Channel& channel, const Draft& draft, bool checked) {
  const std::vector<Device>& devices = draft.file.rig.devices;
  std::string name;
  if (section.value("device") == nullptr) {
    if (devices.size() == 1) channel.device = 0;
    if (devices.size() > 1) section.missing("device", "the name of one of the devices");
    return;
  }
  if (!section.text("device", name, "the name of a device")) return;
  for (std::size_t i = 0; i < devices.size() && channel.device < 0; ++i) {
    if (devices[i].name == name) channel.device = static_cast<int>(i);
  }
  if (channel.device >= 0) return;
  // With a recording as text the file may name devices that it does not describe.
  if (!draft.devices_named || (!checked && devices.empty())) return;
  section.wrong("device", "no device is named " + in_quotes(name) + ": expected " + some_names(devices));
}

std::string places(const Draft& draft, bool with_ground) {
  std::string out = "0 (the table)";
  if (draft.masses_known && draft.file.rig.mass_count() > 0) {
    const std::string last = std::to_string(draft.file.rig.mass_count());
    out += " to " + last + " (mass " + last + ")";
  }
  return with_ground ? out + " or \"ground\"" : out;
}

// A place of the chain under `key`; none: not given, or a mistake that has been noted.
std::optional<int> read_place(Section& section, const char* key, Draft& draft, bool ground_allowed, Need need) {
  const std::string expected = places(draft, ground_allowed);
  const toml::node* node = section.value(key);
  if (node == nullptr) {
    if (need == Need::required) section.missing(key, expected);
    return std::nullopt;
  }
  if (const auto* text = node->as_string(); text != nullptr && text->get() == "ground") {
    if (ground_allowed) return kGround;
  } else if (const auto* number = node->as_integer()) {
    const std::int64_t last = draft.masses_known ? draft.file.rig.mass_count() : static_cast<std::int64_t>(kMaxMasses);
    if (number->get() >= 0 && number->get() <= last) return static_cast<int>(number->get());
  } else if (text == nullptr) {
    section.wrong_type(*node, key, expected);
    return std::nullopt;
  }
  section.wrong(
      key, in_quotes(key) + " is " + shown(*node) + ", no place of the chain for this channel: expected " + expected);
  return std::nullopt;
}

void read_force(Section& section, Channel& channel, Draft& draft, ChannelDraft& notes) {
  channel.at = kGround;
  if (draft.boundary_known && draft.file.rig.boundary == Boundary::free) {
    section.wrong("measures",
                  "a force is measured on a free chain, which has no element to the ground: expected "
                  "boundary \"clamped\", or \"auxiliary\"");
  }
  const toml::node* at = section.value("at");
  const auto* text = at == nullptr ? nullptr : at->as_string();
  notes.place_known = text != nullptr && text->get() == "ground";
  if (at == nullptr) {
    section.missing("at", "\"ground\", where a force is measured");
  } else if (!notes.place_known) {
    section.wrong("at", "\"at\" is " + shown(*at) + ": expected \"ground\", where a force is measured");
  }
  if (section.value("relative_to") != nullptr) {
    section.wrong("relative_to", "\"relative_to\" goes with a motion: expected none with a force");
  }
}

void read_motion(Section& section, Channel& channel, Draft& draft, ChannelDraft& notes) {
  const bool clamped = !draft.boundary_known || draft.file.rig.boundary == Boundary::clamped;
  const std::optional<int> at = read_place(section, "at", draft, false, Need::required);
  const bool relative = section.value("relative_to") != nullptr;
  const std::optional<int> from = read_place(section, "relative_to", draft, clamped, Need::optional);
  channel.at = at.value_or(0);
  notes.place_known = at.has_value() && (!relative || from.has_value());
  // The ground does not move: what is measured against it is the motion itself.
  if (from && *from != kGround) channel.relative_to = from;
  if (at && from && *at == *from) {
    section.wrong("relative_to",
                  "\"relative_to\" is " + std::to_string(*from) + " like \"at\": expected another place of the chain");
    notes.place_known = false;
  }
}

void read_place_and_unit(Section& section, Channel& channel, Draft& draft, ChannelDraft& notes) {
  const Motion motion = draft.file.rig.motion;
  notes.measures_known = section.choice<Quantity>("measures", channel.measures,
                                                  {{"displacement", Quantity::displacement},
                                                   {"velocity", Quantity::velocity},
                                                   {"acceleration", Quantity::acceleration},
                                                   {"force", Quantity::force},
                                                   {"auxiliary", Quantity::auxiliary}},
                                                  Need::required);
  const bool auxiliary = channel.measures == Quantity::auxiliary;
  if (!notes.measures_known || auxiliary) {
    const std::optional<int> at = read_place(section, "at", draft, true, auxiliary ? Need::optional : Need::required);
    channel.at = at.value_or(0);
    notes.place_known = at.has_value();
    const toml::node* relative = section.value("relative_to");
    if (auxiliary && relative) {
      section.wrong("relative_to", "\"relative_to\" goes with a motion: expected none with \"auxiliary\"");
    }
  } else if (channel.measures == Quantity::force) {
    read_force(section, channel, draft, notes);
  } else {
    read_motion(section, channel, draft, notes);
  }

  if (auxiliary) {
    channel.unit.clear();
    section.text("unit", channel.unit, "a unit, any text");
    return;
  }
  const bool checkable = notes.measures_known && draft.motion_known;
  const std::string expected = checkable ? "one of " + unit_names(channel.measures, motion)
                                         : std::string("the unit of what the channel measures");
  if (!section.text("unit", channel.unit, expected.c_str(), Need::required) || !checkable) return;
  if (const std::optional<double> factor = si_per_unit(channel.measures, motion, channel.unit)) {
    channel.si_per_unit = *factor;
  } else {
    section.wrong("unit", "\"unit\" is " + in_quotes(channel.unit) + ", no unit of " + to_string(channel.measures) +
                              " in " + to_string(motion) + ": expected " + expected);
  }
}

Filter read_filter(Section& channel, const char* key, Draft& draft) {
  Filter filter;
  const toml::table* table = channel.table(key, "a table { type, order, hz }");
  if (table == nullptr) return filter;
  Section section(*table, in_quotes(key), draft.mistakes);
  section.choice<FilterKind>(
      "type", filter.kind,
      {{"butterworth", FilterKind::butterworth}, {"bessel", FilterKind::bessel}, {"rc", FilterKind::rc}},
      Need::required);
  std::int64_t order = 0;
  section.integer("order", order, 1, 8, "an integer from 1 to 8", Need::required);
  filter.order = static_cast<int>(order);
  section.real("hz", filter.hz, {"the corner, above 0, at most 1e9 (Hz)", 0.0, 1e9, true}, Need::required);
  filter.hz_u_stated = section.real("hz_u", filter.hz_u, {"a number 0 or more (Hz)", 0.0, 1e9});
  if (filter.hz_u_stated && filter.hz > 0.0 && filter.hz_u >= filter.hz) {
    section.wrong("hz_u", "\"hz_u\" is " + number_text(filter.hz_u) + ": expected less than the corner itself, " +
                              number_text(filter.hz) + " Hz");
  }
  section.refuse_rest();
  return filter;
}

void read_range(Section& section, Channel& channel) {
  double low = 0.0, high = 0.0;
  if (!section.interval("range", low, high, "[low, high] in the channel's unit, low < high")) return;
  channel.range.low = low;
  channel.range.high = high;
}

void read_calibration(Section& channel_section, Channel& channel, Draft& draft) {
  const toml::table* table = channel_section.table("calibration", "a table { id, due }");
  if (table == nullptr) return;
  Section section(*table, "\"calibration\"", draft.mistakes);
  section.text("id", channel.calibration.id, "the number of the certificate, text", Need::required);
  if (const toml::node* due = section.value("due")) {
    if (const auto* date = due->as_date()) {
      std::ostringstream text;
      text << date->get();
      channel.calibration.due = text.str();
    } else {
      section.wrong_type(*due, "due", "a date without quotes, for instance 2027-03-31");
    }
  }
  section.refuse_rest();
}

void read_conversion(Section& section, Channel& channel, Draft& draft) {
  if (section.real("scale", channel.scale, {"a number other than 0"}) && channel.scale == 0.0) {
    section.wrong("scale", "\"scale\" is 0: expected a number other than 0");
  }
  section.real("offset", channel.offset, {"a number, in the channel's unit"});
  channel.stated.scale_u =
      section.real("scale_u", channel.scale_u, {"a number from 0, below 1 (relative)", 0.0, 1.0, false, true});
  section.real("delay", channel.delay_s, {"a number from -10 to 10 (s)", -10.0, 10.0});
  channel.stated.delay_u = section.real("delay_u", channel.delay_u_s, {"a number from 0 to 10 (s)", 0.0, 10.0});
  channel.lowpass = read_filter(section, "lowpass", draft);
  channel.highpass = read_filter(section, "highpass", draft);
  if (channel.lowpass.hz > 0.0 && channel.highpass.hz >= channel.lowpass.hz) {
    section.wrong("highpass",
                  "the corner of \"highpass\" is not below that of \"lowpass\", so that nothing passes: "
                  "expected less than " +
                      number_text(channel.lowpass.hz) + " Hz");
  }
  read_range(section, channel);
  read_calibration(section, channel, draft);
}

void read_positive(Section& section, Channel& channel, const ChannelDraft& notes) {
  const bool given = section.value("positive") != nullptr;
  if (given && notes.measures_known && channel.measures != Quantity::force) {
    section.wrong("positive", "\"positive\" goes with a force: expected none with \"" +
                                  std::string(to_string(channel.measures)) + "\"");
  } else if (given) {
    section.choice<bool>("positive", channel.force_on_mass, {{"ground", false}, {"mass", true}});
  }
}

void read_channel(const toml::table& table, bool checked, Draft& draft) {
  ChannelDraft notes{Section(table, "[[channel]]", draft.mistakes)};
  Section& section = notes.section;
  Channel channel;
  const std::size_t index = draft.channels.size();
  read_name(section, channel, index + 1);
  read_device_of(section, channel, draft, checked);
  read_place_and_unit(section, channel, draft, notes);
  read_positive(section, channel, notes);
  read_conversion(section, channel, draft);

  DeviceDraft* device = channel.device < 0 ? nullptr : &draft.devices[static_cast<std::size_t>(channel.device)];
  const std::size_t before = draft.mistakes.count();
  std::vector<Entry> entries =
      read_driver_keys(section, device == nullptr ? nullptr : device->driver, DWELL_CHANNEL, draft.mistakes);
  if (device != nullptr) {
    device->clean = device->clean && draft.mistakes.count() == before;
    draft.file.devices[static_cast<std::size_t>(channel.device)].channels.push_back(
        {channel.name, static_cast<std::uint16_t>(index), std::move(entries)});
  }
  draft.file.rig.channels.push_back(std::move(channel));
  draft.channels.push_back(std::move(notes));
}

}  // namespace

void read_channels(Section& root, const SchemaSource& schemas, Draft& draft) {
  const toml::array* channels = root.array("channel", "at least one table [[channel]]", Need::required);
  if (channels == nullptr) return;
  if (channels->size() > kMaxChannels) {
    root.wrong("channel",
               std::to_string(channels->size()) + " channels: expected at most " + std::to_string(kMaxChannels));
    return;
  }
  draft.channels.reserve(channels->size());
  for (const toml::node& node : *channels) {
    if (const toml::table* table = node.as_table()) {
      read_channel(*table, static_cast<bool>(schemas), draft);
    } else {
      draft.mistakes.add(position(node),
                         std::string("a channel is ") + type_name(node) + ": expected a table [[channel]]");
    }
  }
}

}  // namespace dwell::config
