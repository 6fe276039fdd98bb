#include "daemon/ctl/run_source.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "daemon/record/regular_file.hpp"

namespace dwell::ctl {
namespace {

constexpr std::uint64_t kProgressEvery = 1U << 12U;  // records

std::string listed(const std::vector<std::string>& names) {
  if (names.empty()) return "none";
  std::string text;
  for (const std::string& name : names) text.append(text.empty() ? "" : ", ").append(name);
  return text;
}

// Of those that `of` lacks.
std::vector<std::string> missing(const std::vector<std::string>& names, const std::vector<std::string>& of) {
  std::vector<std::string> out;
  for (const std::string& name : names)
    if (std::find(of.begin(), of.end(), name) == of.end()) out.push_back(name);
  return out;
}

}  // namespace

bool is_run_file(const std::string& path) {
  static constexpr std::string_view kMagic{"SQLite format 3\0", 16};
  std::array<char, kMagic.size()> begin{};
  const auto file = record::open_regular(path);
  return file && ::read(file->get(), begin.data(), begin.size()) == static_cast<ssize_t>(begin.size()) &&
         std::string_view(begin.data(), begin.size()) == kMagic;
}

std::string why_no_stream(const std::string& path, const record::RunHeader& child) {
  return path + " holds no stream: it was computed from run " + child.parent_id + "; expected the file of that run";
}

tl::expected<config::RigFile, std::string> rig_of(const record::RunHeader& header, const std::string& path) {
  const std::string place = path + ": its rig file " + header.rig.path;
  auto file = config::parse(header.rig.text, header.rig.path, {});
  if (!file) {
    const std::string why = config::to_string(header.rig.path, file.error());
    return tl::unexpected(place + " is not one that this version reads: " + why.substr(0, why.find('\n')));
  }
  return std::move(*file);
}

tl::expected<ChannelMap, std::string> ChannelMap::between(const record::RunHeader& header, const std::string& run_path,
                                                          const Rig& rig, const std::string& rig_path) {
  std::vector<std::string> names;
  for (const Channel& channel : rig.channels) names.push_back(channel.name);
  const std::vector<std::string> lacking = missing(header.channels, names), surplus = missing(names, header.channels);
  if (!lacking.empty() || !surplus.empty() || names.size() != header.channels.size())
    return tl::unexpected(rig_path + ": expected the channels of " + run_path +
                          ", in any order; missing: " + listed(lacking) + "; not in the run: " + listed(surplus));
  ChannelMap map;
  if (names == header.channels) return map;
  for (const std::string& name : header.channels)
    map.to_.push_back(static_cast<std::uint16_t>(std::find(names.begin(), names.end(), name) - names.begin()));
  return map;
}

tl::expected<void, std::string> RunSource::play(const Progress& progress, const Take& take) const {
  const std::int64_t begin_ns = reader_.begin_ns();
  const double length_ns = std::max(static_cast<double>(reader_.end_ns() - begin_ns), 1.0);
  std::optional<std::int64_t> origin_ns;
  std::uint64_t taken = 0;
  const auto played = reader_.stream([&](const Record& stored) {
    if (progress && ++taken % kProgressEvery == 0) progress(static_cast<double>(stored.t_ns - begin_ns) / length_ns);
    if (!concerns_pipeline(stored.kind)) return true;
    if (!origin_ns) origin_ns = stored.t_ns;
    Record record = channels_.map(stored);
    record.t_ns -= *origin_ns;
    take(record);
    return true;
  });
  if (progress) progress(1.0);
  if (!played) return tl::unexpected<std::string>(played.error());
  return {};
}

}  // namespace dwell::ctl
