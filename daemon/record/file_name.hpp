// Names in a recording directory. A run file's is RIG-RUN-UTC.dwell, for instance
// "suspension-bench-2-17-20261123T031217Z.dwell".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace dwell::record {

inline constexpr std::string_view kRunSuffix = ".dwell";
// A file NAME.dwell.keep beside NAME.dwell protects it: retention never deletes it.
inline constexpr std::string_view kKeepSuffix = ".keep";

// The ledger in a recording directory.
[[nodiscard]] std::string ledger_in(const std::string& directory);

// Keeps letters, digits, "." and "_" of `text`; makes each sequence of other characters one "-". At most 64 bytes,
// neither empty nor hidden.
[[nodiscard]] std::string tame(std::string_view text);

// `utc`: as compact_utc() writes it.
[[nodiscard]] std::string run_file_name(std::string_view rig, std::int64_t run, std::string_view utc);

// The name at which a run's file is made. It loses this name once the ledger knows the run.
[[nodiscard]] std::string first_name_of_run(std::int64_t run);

// What the file is, if it has the name of one that the service keeps in its recording directory beside runs and ledger:
// its keys, the reserve, runs made in advance. Empty: it has none of these names.
[[nodiscard]] std::string kept_by_service(std::string_view name);

// The run's number in a file's name; 0: none.
[[nodiscard]] std::int64_t run_of_file_name(std::string_view name);

}  // namespace dwell::record
