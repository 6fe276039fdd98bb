// Makes the recorder of a session as its rig file asks for, and states the rig and the program in every run's file.
#pragma once

#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "config/rig_file.hpp"
#include "daemon/log/log.hpp"
#include "daemon/record/recorder.hpp"

namespace dwell {

// The directory of the recordings: the one in the rig file; else the one that systemd gives the service; else
// /var/lib/dwell.
[[nodiscard]] std::string recording_directory(const config::RigFile& file);

// The name of a new key: "dwell-RIG-HOST".
[[nodiscard]] std::string key_name(const config::RigFile& file);

// A running recorder; null if the rig file has no [recording]. The log must outlive it. Fails if a file that the rig
// file names cannot be read.
[[nodiscard]] tl::expected<std::unique_ptr<record::Recorder>, std::string> make_recorder(
    const config::RigFile& file, const config::SchemaSource& drivers, Log& log);

}  // namespace dwell
