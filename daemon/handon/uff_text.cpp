#include "daemon/handon/uff_text.hpp"

#include <array>
#include <bit>
#include <cstdio>
#include <cstring>

#include "config/units.hpp"
#include "daemon/handon/printf_text.hpp"

namespace dwell::handon {
namespace {

constexpr std::size_t kColumns = 80;
constexpr std::int64_t kValuesPerLine = 4;  // 4E20.12
constexpr std::int64_t kValueColumns = 20;

// Numbers of the format.
constexpr int kTimeResponse = 1;
constexpr int kRealDouble = 4;
constexpr int kEven = 1;
constexpr int kTime = 17;

int specific_type(const Channel& channel) {
  switch (channel.measures) {
    case Quantity::displacement:
      return 8;
    case Quantity::velocity:
      return 11;
    case Quantity::acceleration:
      return 12;
    case Quantity::force:
      return channel.at == kGround ? 9 : 13;  // reaction force, excitation force
    case Quantity::auxiliary:
      return 0;
  }
  return 0;
}

std::string ascii(std::string_view text) {
  std::string clean;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xC0U) == 0x80U) continue;  // one sign per character of UTF-8
    clean += c >= ' ' && c <= '~' ? c : '?';
  }
  return clean;
}

std::string axis(int type, int length, int force, const std::string& label, const std::string& unit) {
  return uff_line(
      format("%10d%5d%5d%5d %-20.20s %-20.20s", type, length, force, 0, ascii(label).c_str(), ascii(unit).c_str()));
}

std::string ordinate(const Channel& channel, Motion motion) {
  const bool rotation = motion == Motion::rotation;
  const bool auxiliary = channel.measures == Quantity::auxiliary;
  const bool force = channel.measures == Quantity::force;
  const std::string unit = auxiliary ? channel.unit : config::si_unit(channel.measures, motion);
  std::string label = auxiliary ? channel.name : config::to_string(channel.measures);
  if (force && rotation) label = "torque";
  const int length = auxiliary ? 0 : force ? (rotation ? 1 : 0) : (rotation ? 0 : 1);
  return axis(specific_type(channel), length, force ? 1 : 0, label, unit.empty() ? "NONE" : unit);
}

}  // namespace

std::string uff_line(std::string_view text) {
  std::string line = ascii(text);
  line.resize(kColumns, ' ');
  return line + "\n";
}

std::string uff_date(const std::string& utc) {
  static constexpr std::array<const char*, 12> months{"JAN", "FEB", "MAR", "APR", "MAY", "JUN",
                                                      "JUL", "AUG", "SEP", "OCT", "NOV", "DEC"};
  int year = 0, month = 0, day = 0, hour = 0, minute = 0, second = 0;
  const int found = std::sscanf(utc.c_str(), "%4d-%2d-%2dT%2d:%2d:%2d", &year, &month, &day, &hour, &minute, &second);
  if (found != 6 || month < 1 || month > 12) return utc;
  return format("%02d-%s-%02d %02d:%02d:%02d", day, months[static_cast<std::size_t>(month - 1)], year % 100, hour,
                minute, second);
}

std::string uff_header(const UffHeader& header) {
  const auto date = [](const std::string& utc) {
    const std::string text = uff_date(utc);
    return format("%-10.9s%-10.8s", text.c_str(), text.size() > 10 ? text.c_str() + 10 : "");
  };
  std::string text(kUffMark);
  text += uff_line("   151");
  text += uff_line(header.model);
  text += uff_line(header.description);
  text += uff_line(header.program);
  text += uff_line(date(header.created_utc) + format("%10d%10d%10d", 0, 0, 0));
  text += uff_line(date(header.created_utc));
  text += uff_line(header.program);
  text += uff_line(date(header.written_utc));
  return text.append(kUffMark);
}

std::string uff_units() {
  std::string text(kUffMark);
  text += uff_line("   164");
  text += uff_line(format("%10d%-20s%10d", 1, "SI: Meter (newton)", 1));
  std::string factors = format("%25.17E%25.17E%25.17E", 1.0, 1.0, 1.0);
  std::string offset = format("%25.17E", 273.15);
  for (std::string* line : {&factors, &offset}) {
    for (char& c : *line)
      if (c == 'E') c = 'D';
    text += uff_line(*line);
  }
  return text.append(kUffMark);
}

std::string uff_function(const UffFunction& f) {
  const Channel& channel = *f.channel;
  std::string text(kUffMark);
  text += f.binary ? uff_line(format("    58b%6d%6d%12d%12lld%6d%6d%12d%12d", 1, 2, 11,
                                     static_cast<long long>(uff_values_size(f.count, true)), 0, 0, 0, 0))
                   : uff_line("    58");
  for (const std::string* line : {&f.description, &f.run, &f.date, &f.method, &f.error}) text += uff_line(*line);
  const std::string name = ascii(channel.name);
  const int node = channel.at == kGround ? f.node_of_ground : channel.at;
  const int direction = channel.measures == Quantity::auxiliary ? 0 : f.motion == Motion::rotation ? 4 : 1;
  text += uff_line(format("%5d%10d%5d%10d %-10.10s%10d%4d %-10.10s%10d%4d", kTimeResponse, f.number, f.stretch, 0,
                          name.c_str(), channel.measures == Quantity::auxiliary ? 0 : node, direction, "NONE", 0, 0));
  text += uff_line(format("%10d%10lld%10d%13.5E%13.5E%13.5E", kRealDouble, static_cast<long long>(f.count), kEven,
                          f.start_s, f.step_s, 0.0));
  text += axis(kTime, 0, 0, "time", "s");
  text += ordinate(channel, f.motion);
  text += axis(0, 0, 0, "NONE", "NONE");
  text += axis(0, 0, 0, "NONE", "NONE");
  return text;
}

std::int64_t uff_values_size(std::int64_t count, bool binary) noexcept {
  const std::int64_t lines = (count + kValuesPerLine - 1) / kValuesPerLine;
  return binary ? count * static_cast<std::int64_t>(sizeof(double)) : count * kValueColumns + lines;
}

void uff_value(std::string& text, double value, std::int64_t index, std::int64_t count, bool binary) {
  if (binary) {
    static_assert(std::endian::native == std::endian::little, "the file says little-endian");
    std::array<char, sizeof value> bytes{};
    std::memcpy(bytes.data(), &value, sizeof value);
    text.append(bytes.data(), bytes.size());
    return;
  }
  std::array<char, 32> digits{};
  const int length = std::snprintf(digits.data(), digits.size(), "%20.12E", value);
  text.append(digits.data(), static_cast<std::size_t>(length));
  if (index % kValuesPerLine == kValuesPerLine - 1 || index == count - 1) text += '\n';
}

}  // namespace dwell::handon
