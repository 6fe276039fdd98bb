#include "daemon/handon/csv.hpp"

#include <array>
#include <charconv>
#include <vector>

#include "config/units.hpp"
#include "daemon/handon/output_file.hpp"
#include "daemon/report/number_text.hpp"

namespace dwell::handon {
namespace {

std::string comment(const std::string& text) { return "# " + printable(text) + "\n"; }

std::string channel_comment(const Channel& channel) {
  std::string text = "channel " + channel.name + ": " + measurand_text(channel) + "; in " +
                     (channel.unit.empty() ? "(no unit)" : channel.unit) + " = " + shortest(channel.scale) +
                     " * value + " + shortest(channel.offset);
  if (!channel.calibration.id.empty())
    text += "; calibration " + channel.calibration.id +
            (channel.calibration.due.empty() ? "" : ", due " + channel.calibration.due);
  return comment(text);
}

std::string preamble(const Selection& selection, const Provenance& provenance) {
  const record::RunHeader& run = selection.header();
  std::string text = comment("run " + std::to_string(run.run) + (run.label.empty() ? "" : ", " + run.label) + "; rig " +
                             selection.rig().name + "; begun " + run.start_utc + " on " + run.origin.host + ", clock " +
                             clock_text(run.origin));
  text += comment("id " + run.id + "; head " + head_text(provenance) + "; audit: " + provenance.audit);
  text += comment("made by " + provenance.program + ", " + provenance.made_utc);
  text += comment("t: s on the run's axis, exact to 1 ns. value: the device's own number.");
  for (const Channel& channel : selection.rig().channels) text += channel_comment(channel);
  return text;
}

}  // namespace

std::string exact_seconds(std::int64_t t_ns) {
  constexpr std::uint64_t second = 1'000'000'000;
  const std::uint64_t size = t_ns < 0 ? 0 - static_cast<std::uint64_t>(t_ns) : static_cast<std::uint64_t>(t_ns);
  std::array<char, 32> text{};
  char* at = text.data();
  if (t_ns < 0) *at++ = '-';
  at = std::to_chars(at, text.data() + text.size(), size / second).ptr;
  *at++ = '.';
  std::uint64_t rest = size % second;
  for (std::uint64_t place = second / 10; place > 0; place /= 10) {
    *at++ = static_cast<char>('0' + rest / place);
    rest %= place;
  }
  return {text.data(), at};
}

std::string shortest(double value) {
  std::array<char, 40> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

Result<std::uint64_t> export_csv(Selection& selection, const Provenance& provenance, const CsvOptions& options,
                                 const Target& target, const Progress& progress) {
  auto file = OutputFile::create(target);
  if (!file) return tl::make_unexpected(file.error());
  file->write(preamble(selection, provenance));
  file->write(options.in_unit ? "t,channel,value,in_unit,unit\n" : "t,channel,value\n");
  const std::vector<Channel>& channels = selection.rig().channels;
  std::uint64_t count = 0;
  std::string line;
  const auto take = [&](const Record& record) {
    const Channel& channel = channels[record.channel];
    line = exact_seconds(record.t_ns - selection.zero_ns());
    line.append(",").append(channel.name).append(",").append(shortest(record.value));
    if (options.in_unit)
      line.append(",").append(shortest(in_unit(channel, record.value))).append(",").append(channel.unit);
    line += '\n';
    file->write(line);
    ++count;
    return true;
  };
  if (auto done = selection.samples(take, progress); !done) return tl::make_unexpected(done.error());
  if (auto done = file->keep(); !done) return tl::make_unexpected(done.error());
  return count;
}

}  // namespace dwell::handon
