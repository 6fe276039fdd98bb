// Run files for the tests of the audit: however they end, and then altered as a forger would. What a run file holds in
// full is in sample_run.hpp.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "daemon/record/chain_file.hpp"
#include "daemon/record/keys.hpp"
#include "daemon/record/run_entries.hpp"
#include "tests/record/scratch.hpp"

namespace dwell::record {

// How a run file ends.
enum class SampleEnd : std::uint8_t {
  closed,
  signed_by_service,
  signed_by_own_key,
  signed_by_both,
  log_left,    // cut off: a file and its -wal
  log_folded,  // cut off, and its -wal is in the file
};

struct SampleFile {
  unsigned seed = 0;
  SampleEnd end = SampleEnd::closed;
  int blocks = 5;
  int records = 200;  // of a block
  RunHeader header{};
};

[[nodiscard]] const SigningKey& sample_key();    // the service's
[[nodiscard]] const SigningKey& sample_other();  // anybody else's

// What Anna says under a run: she has reviewed it.
[[nodiscard]] PersonalSignature sample_words();

// A header that is complete.
[[nodiscard]] RunHeader sample_header(std::int64_t run, const SigningKey& key);

// Writes the run to `path`; its final head.
std::string write_sample(const std::string& path, SampleFile run, const SigningKey& key = sample_key());
[[nodiscard]] std::uint64_t sample_count(const SampleFile& run);  // samples in it

// What a reader sees: each row as one text. One text "unreadable" where it fails.
[[nodiscard]] std::vector<std::string> rows_of(const std::string& path, ChainSort sort = ChainSort::run);

// The files of a directory with their bytes, and back.
using Files = std::map<std::string, std::string>;
[[nodiscard]] Files files_in(const Scratch& scratch);
void put_files(const Scratch& scratch, const Files& files);

// Runs SQL on a file as anybody can who may write it. False: SQLite refused it.
bool forge(const std::string& path, const std::string& sql);

// Computes all heads of the chain anew, as a forger without a key can.
void forge_heads(const std::string& path);

}  // namespace dwell::record
