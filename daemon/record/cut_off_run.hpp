// What a crash has left of runs in a recording directory. Alters nothing.
#pragma once

#include <cstdint>
#include <string>

#include "daemon/record/result.hpp"

namespace dwell::record {

// A run that a crash or a loss of power ended.
struct CutOffRun {
  std::int64_t run = 0;
  std::string file;       // its name in the directory; empty: there is none
  std::string until_utc;  // of its last entry; empty: not known
  std::string label, comment;
  std::string trouble;  // why its file cannot be read, so that the ledger has no head of it; empty: it can
};

// The end of a file that nobody writes any more.
struct FileEnd {
  CutOffRun run;
  std::string head;  // of the last entry, hexadecimal; empty: it has none
  std::int64_t seq = 0;
  bool closed = false;
};
// Reads the chain of the run's file to its end: the time goes with its size. Fails with the reason if it cannot be
// read, which no crash causes.
[[nodiscard]] Result<FileEnd> end_of_file(const std::string& directory, CutOffRun run);

// The file with this number in its name; empty: there is none.
[[nodiscard]] std::string file_of_run(const std::string& directory, std::int64_t run);
[[nodiscard]] bool is_there(const std::string& directory, const std::string& name);
// Whether different files stand at the two names.
[[nodiscard]] bool are_two_files(const std::string& a, const std::string& b);

}  // namespace dwell::record
