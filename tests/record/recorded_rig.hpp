// A recording directory with what a RunLog or a Recorder needs around it.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "daemon/record/recorder.hpp"
#include "daemon/record/run_folder.hpp"
#include "daemon/record/run_log.hpp"

namespace dwell::record {

inline RunHeader rig_header() {
  RunHeader header;
  header.rig = {"rig.toml", std::string(64, 'a'), "[rig]\nname = \"bench\"\n"};
  header.channels = {"y0", "y1"};
  header.label = "rubber 3";
  header.comment = "cold";
  header.origin.clock_synchronized = true;
  return header;
}

inline FolderOptions folder_options(const std::string& directory) {
  FolderOptions options;
  options.directory = directory;
  options.rig = "bench";
  options.key_name = "dwell-bench";
  options.reserve_bytes = 2'000'000;
  options.room_bytes = 1'000'000;
  return options;
}

// Notices, from whatever thread.
class Notices {
 public:
  [[nodiscard]] Tell tell() {
    return [this](const Notice& notice) {
      const std::lock_guard lock(mutex_);
      all_.push_back(notice);
    };
  }
  [[nodiscard]] bool hold(const std::string& part) const {
    const std::lock_guard lock(mutex_);
    for (const Notice& notice : all_)
      if (notice.text.find(part) != std::string::npos) return true;
    return false;
  }
  [[nodiscard]] std::string text() const {
    const std::lock_guard lock(mutex_);
    std::string lines;
    for (const Notice& notice : all_) lines += notice.text + "\n";
    return lines;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<Notice> all_;
};

inline RunLogOptions log_options(Notices& notices) {
  return {
      rig_header,
      [](const Dwell&, const std::string&) { return std::string("{\"index\":1}"); },
      [](const ModelResult&) {
        return StoredModel{"estimate", 0, {}, "{\"last\":9}", "{\"motion\":null}"};
      },
      [](State before, const Dwell& after) { return std::string(to_string(before)) + " -> " + to_string(after.state); },
      notices.tell(),
      {}};
}

inline RecorderOptions recorder_options(const std::string& directory, Notices& notices) {
  RecorderOptions options;
  options.folder = folder_options(directory);
  options.rate_hz = 10'000.0;
  options.header = rig_header;
  options.dwell_json = [](const Dwell&, const std::string&) { return std::string("{\"index\":1}"); };
  options.state_line = [](State, const Dwell&) { return std::string("changed"); };
  options.tell = notices.tell();
  options.clock_synchronized = [] { return true; };
  return options;
}

}  // namespace dwell::record
