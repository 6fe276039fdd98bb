// Makes and opens the SQLite database of a chain, for whoever writes to it (chain_writer.cpp).
#pragma once

#include <string>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/result.hpp"
#include "daemon/record/sqlite.hpp"

namespace dwell::record {

// Bytes of a page. A block has 10 kB to some MB, so larger pages mean fewer links to follow. But each commit, one a
// second, rewrites about three pages.
inline constexpr int kPageBytes = 16384;

inline constexpr const char* kWaits = "PRAGMA synchronous = FULL";   // SQLite waits for the disk at each commit
inline constexpr const char* kNoWaits = "PRAGMA synchronous = OFF";  // it does not: whoever commits must

// Makes an empty chain under another name, waits for the disk once, then renames the file to `path`. The rename
// survives a loss of power from the first commit on: SQLite then synchronizes the directory for the -wal. Fails where
// there is such a file already.
[[nodiscard]] Result<void> make_chain_database(const std::string& path, ChainSort sort);

// Opens it to write, with a log that is moved into the database on demand alone. Fails with the reason; while another
// process has it open, asks `busy` whether to try again.
[[nodiscard]] Result<Database> open_chain_database(const std::string& path, const WhileBusy& busy);

// Whether a log may stand beside the file, which whoever writes needs; fails with the reason.
[[nodiscard]] Result<void> may_have_log(const std::string& path);

// Waits until what the directory of `path` says of its files survives a loss of power. errno says why not.
[[nodiscard]] bool synchronize_directory(const std::string& path);

}  // namespace dwell::record
