#include "daemon/run/recording.hpp"

#include <unistd.h>

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "config/sha256.hpp"
#include "daemon/record/file_name.hpp"
#include "daemon/record/file_sha256.hpp"
#include "daemon/record/small_file.hpp"
#include "daemon/report/dwell_json.hpp"
#include "daemon/report/dwell_line.hpp"
#include "daemon/run/stored_model.hpp"
#include "daemon/version.hpp"

namespace dwell {
namespace {

// Files that the rig file names are kept in the run file up to this size. A larger one is not a description of the rig
// but data, for instance a recording to be replayed: only its name and its SHA-256 are kept.
constexpr std::uintmax_t kKeptFileBytes = 4u << 20;
// Most bytes of larger files, all together, that are read for their SHA-256 as the service starts: a disk of 100 MB/s
// takes 11 s for them, and systemd waits 90 s. Halved, a longer recording is kept by name alone.
constexpr std::uintmax_t kHashedBytes = 1u << 30;
// Of the JSON of a run's header, for what comes to it as the run begins: label, comment, origin, keys.
constexpr std::size_t kHeaderRoom = 64u << 10;
// Readings of a channel per second that are assumed for a device without a stated rate, a bus for instance.
constexpr double kUnstatedRate_hz = 1000.0;

// Files among the values that drivers are given.
std::vector<std::string> files_named(const config::RigFile& file) {
  std::vector<std::string> names;
  const auto take = [&](const std::vector<config::Entry>& entries) {
    for (const config::Entry& entry : entries) {
      const auto* text = std::get_if<std::string>(&entry.value);
      std::error_code failed;
      if (text != nullptr && !text->empty() &&
          std::filesystem::is_regular_file(std::filesystem::path(file.directory) / *text, failed))
        if (std::find(names.begin(), names.end(), *text) == names.end()) names.push_back(*text);
    }
  };
  for (const config::DeviceSettings& device : file.devices) {
    take(device.entries);
    for (const config::ChannelSettings& channel : device.channels) take(channel.entries);
  }
  return names;
}

std::string megabytes(std::uintmax_t bytes) { return std::to_string(bytes / 1'000'000) + " MB"; }

// Keeps the files that a rig file names, one after the other.
class FileKeeper {
 public:
  FileKeeper(std::filesystem::path directory, Log& log) : directory_(std::move(directory)), log_(log) {}

  tl::expected<record::KeptFile, std::string> keep(const std::string& name) {
    const std::string path = (directory_ / name).string();
    std::error_code failed;
    const std::uintmax_t bytes = std::filesystem::file_size(path, failed);
    if (!failed && bytes > kKeptFileBytes) return keep_hash(name, path, bytes);
    auto text = record::read_small_file(path, kKeptFileBytes);
    if (!text) return tl::unexpected(std::move(text.error()));
    return record::KeptFile{name, config::sha256(*text), std::move(*text)};
  }

 private:
  tl::expected<record::KeptFile, std::string> keep_hash(const std::string& name, const std::string& path,
                                                        std::uintmax_t bytes) {
    record::Result<std::optional<std::string>> sha256;  // none: too large
    if (bytes <= left_) sha256 = record::file_sha256(path, left_);
    if (!sha256) return tl::unexpected(std::move(sha256.error()));
    if (!*sha256) {
      log_.warning(path + " has " + megabytes(bytes) +
                   ": run files will hold its name, neither its text nor its SHA-256");
      return record::KeptFile{name, {}, {}};
    }
    left_ -= std::min(left_, bytes);
    log_.info(path + " has " + megabytes(bytes) + ": run files will hold its SHA-256, not its text");
    return record::KeptFile{name, std::move(**sha256), {}};
  }

  const std::filesystem::path directory_;
  Log& log_;
  std::uintmax_t left_ = kHashedBytes;
};

std::string too_large(const config::RigFile& file, const record::RunHeader& header, std::size_t bytes) {
  std::string text = file.path + ": with the files that it names it takes " + std::to_string(bytes) +
                     " bytes of each run file, as JSON; at most " + std::to_string(record::kMaxJson - kHeaderRoom) +
                     " can be read back. The files:";
  for (const record::KeptFile& kept : header.files)
    text += " " + kept.path + " (" + std::to_string(kept.text.size()) + " bytes)";
  return text;
}

tl::expected<record::RunHeader, std::string> header_of(const config::RigFile& file, const config::SchemaSource& drivers,
                                                       Log& log) {
  record::RunHeader header;
  header.rig = {file.path, file.sha256, file.text};
  FileKeeper keeper(file.directory, log);
  for (const std::string& name : files_named(file)) {
    auto kept = keeper.keep(name);
    if (!kept) return tl::unexpected(std::move(kept.error()));
    header.files.push_back(std::move(*kept));
  }
  for (const config::DeviceSettings& device : file.devices) {
    const auto table = drivers ? drivers(device.driver) : tl::unexpected(std::string());
    const bool states = table && (*table)->version != nullptr;
    header.plugins.push_back({device.driver, states ? (*table)->version : ""});
  }
  for (const Channel& channel : file.rig.channels) header.channels.push_back(channel.name);
  if (const std::size_t bytes = to_json(header).size(); bytes > record::kMaxJson - kHeaderRoom)
    return tl::unexpected(too_large(file, header, bytes));
  return header;
}

double samples_per_second(const config::RigFile& file) {
  double rate_hz = 0.0;
  for (const config::DeviceSettings& device : file.devices)
    rate_hz += static_cast<double>(device.channels.size()) * device.rate_hz.value_or(kUnstatedRate_hz);
  return rate_hz;
}

Level level_of(record::Notice::Grade grade) {
  switch (grade) {
    case record::Notice::Grade::info:
      return Level::info;
    case record::Notice::Grade::warning:
      return Level::warning;
    case record::Notice::Grade::error:
      return Level::error;
  }
  return Level::error;
}

}  // namespace

std::string recording_directory(const config::RigFile& file) {
  const char* const given = std::getenv("STATE_DIRECTORY");
  const std::string state = given == nullptr ? "" : given;
  const bool named = file.recording.directory != config::RecordingSettings().directory;
  return named || state.empty() ? file.recording.directory : state.substr(0, state.find(':'));
}

std::string key_name(const config::RigFile& file) {
  char host[HOST_NAME_MAX + 1] = {};
  gethostname(host, sizeof host - 1);
  // At most 100 characters; tame() gives 64.
  return record::tame("dwell-" + record::tame(file.rig.name) + "-" + host);
}

tl::expected<std::unique_ptr<record::Recorder>, std::string> make_recorder(const config::RigFile& file,
                                                                           const config::SchemaSource& drivers,
                                                                           Log& log) {
  if (!file.recording.on) return nullptr;
  auto header = header_of(file, drivers, log);
  if (!header) return tl::unexpected(std::move(header.error()));
  record::RecorderOptions options;
  options.folder.directory = recording_directory(file);
  options.folder.rig = file.rig.name;
  options.folder.key_name = key_name(file);
  options.retention = {file.recording.retain_days, file.recording.retain_gigabytes};
  if (const auto& anchor = file.recording.anchor) options.anchor = {anchor->minutes, anchor->file, anchor->command};
  options.rate_hz = samples_per_second(file);
  options.header = [base = std::move(*header)] {
    record::RunHeader fresh = base;
    fresh.origin = record::this_origin();
    return fresh;
  };
  options.dwell_json = [rig = file.rig, sha256 = file.sha256](const Dwell& dwell, const std::string& start_utc) {
    return to_json(dwell, rig, RunInfo{sha256, kVersion, start_utc});
  };
  options.model_json = [rig = file.rig](const record::ModelResult& result) { return stored_model(result, rig); };
  options.state_line = state_line;
  options.tell = [&log](const record::Notice& notice) {
    const std::string run = std::to_string(notice.run);
    log.write(level_of(notice.grade), notice.text, {{"DWELL_RUN", run}, {"DWELL_HEAD", notice.head}});
  };
  for (const Channel& channel : file.rig.channels) options.names.channels.push_back(channel.name);
  for (const config::DeviceSettings& device : file.devices) options.names.devices.push_back(device.name);
  return std::make_unique<record::Recorder>(std::move(options));
}

}  // namespace dwell
