// The recorder of a session: what its rig file asks for, and what every run's file says of the rig and the program.
#pragma once

#include <memory>
#include <string>
#include <tl/expected.hpp>

#include "config/rig_file.hpp"
#include "daemon/log/log.hpp"
#include "daemon/record/recorder.hpp"

namespace dwell {

// Where runs are recorded: what the rig file names; where it names nothing, the directory that systemd gives the
// service, else /var/lib/dwell.
[[nodiscard]] std::string recording_directory(const config::RigFile& file);

// What a new key is called: "dwell-RIG-HOST".
[[nodiscard]] std::string key_name(const config::RigFile& file);

// A recorder, its thread running; null where the rig file has no [recording]. The log must outlive it. Fails where a
// file that the rig file names cannot be read.
[[nodiscard]] tl::expected<std::unique_ptr<record::Recorder>, std::string> make_recorder(
    const config::RigFile& file, const config::SchemaSource& drivers, Log& log);

}  // namespace dwell
