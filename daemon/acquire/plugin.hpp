// Finds and loads driver plugins, `dwell-driver-NAME.so`, by name.
//
// Folders searched, in this order: those given; those of $DWELL_DRIVER_PATH (separated by colons); the folder of the
// running program; the plugin folder of the prefix it is installed in (../lib/dwell). The first file found decides: one
// that cannot be used is an error, not a reason to look further. A plugin stays loaded until the program ends, so its
// table is valid for ever. Thread-safe.
#pragma once

#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/dwell_driver.h"

namespace dwell::acquire {

// The folders searched, in order; `given` comes first.
[[nodiscard]] std::vector<std::string> plugin_folders(const std::vector<std::string>& given = {});

// The driver called `name`, checked: interface version, size, name, no function missing. The error is one line that
// says what was tried, and which drivers there are.
[[nodiscard]] tl::expected<const dwell_driver_table*, std::string> load_plugin(
    const std::string& name, const std::vector<std::string>& given = {});

// Names of the drivers in the folders searched, sorted; their files are not opened.
[[nodiscard]] std::vector<std::string> plugin_names(const std::vector<std::string>& given = {});

}  // namespace dwell::acquire
